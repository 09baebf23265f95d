#pragma once

#include "scenegen/scene.h"

#include <filesystem>

namespace dapple::scenegen {

/// `asset.generator` of the files that writeGlb() makes and import/own_gltf.h reads back to the bit.
inline constexpr const char* kGlbGenerator = "dapple scenegen 1";

/// Writes glTF 2.0 binary, y up, metres: one mesh per prototype shared by the nodes of its instances, materials with
/// PNG textures inside the file and alphaMode MASK, views as cameras, sun and local lights by KHR_lights_punctual.
/// What glTF cannot say exactly stands in the scene's `extras`. Whole or not at all. Throws UsageError when the file
/// cannot be written or exceeds 4 GiB.
void writeGlb(const Scene& scene, const std::filesystem::path& path);

}  // namespace dapple::scenegen
