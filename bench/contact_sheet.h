#pragma once

#include "scenegen/scene.h"

#include <filesystem>

namespace dapple::bench {

/// All views of a scene (at most 16) in one PNG, row by row in the scene's order, shaded with cascaded maps.
/// Throws UsageError: no GL context, or a file that cannot be written.
void writeContactSheet(scenegen::Scene scene, int device, const std::filesystem::path& file);

}  // namespace dapple::bench
