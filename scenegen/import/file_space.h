#pragma once

#include "scenegen/import/scene_builder.h"

namespace dapple::scenegen {

/// Unit and axes of a file as its format or the file itself says, as far as Assimp has not applied them: units of FBX,
/// 3MF, AMF, X3D, OpenGEX and DXF; axes of FBX, OpenGEX and of formats that have z up. Others are y up, in metres.
FileSpace spaceOf(const aiScene& scene, const std::filesystem::path& file, Notes& notes);

}  // namespace dapple::scenegen
