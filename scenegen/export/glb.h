#pragma once

#include "scenegen/scene.h"

#include <filesystem>

namespace dapple::scenegen {

/// Writes glTF 2.0 binary, y up, metres: one mesh per prototype shared by the nodes of its instances, materials with
/// PNG textures inside the file and alphaMode MASK, views as cameras, the sun as a directional light
/// (KHR_lights_punctual). Whole or not at all. Throws UsageError when the file cannot be written or exceeds 4 GiB.
void writeGlb(const Scene& scene, const std::filesystem::path& path);

}  // namespace dapple::scenegen
