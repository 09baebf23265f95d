#pragma once

#include "scenegen/import/scene_builder.h"

namespace dapple::scenegen {

/// Unit and axes of a file as its format or the file itself says, as far as Assimp has not applied them.
FileSpace spaceOf(const aiScene& scene, const std::filesystem::path& file);

}  // namespace dapple::scenegen
