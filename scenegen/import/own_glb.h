#pragma once

#include "scenegen/scene.h"

#include <filesystem>
#include <optional>

namespace dapple::scenegen {

/// The scene that writeGlb() wrote, with the same content hash; nothing for a file of other origin, which Assimp reads.
/// Throws UsageError when the file claims to be ours and is damaged.
std::optional<Scene> readOwnGlb(const std::filesystem::path& file);

}  // namespace dapple::scenegen
