#pragma once

#include "scenegen/scene.h"

#include <filesystem>
#include <vector>

namespace dapple::scenegen {

/// Writes Wavefront OBJ, y up, metres, with NAME.mtl and NAME-TEXTURE.png beside it: the format has no instances, so
/// every one is written out. Each file whole or not at all. Throws UsageError when one cannot be written, or when there
/// are more than 50 million triangles.
void writeObj(const Scene& scene, const std::filesystem::path& path);

/// The files that writeObj() writes.
std::vector<std::filesystem::path> objFiles(const Scene& scene, const std::filesystem::path& path);

}  // namespace dapple::scenegen
