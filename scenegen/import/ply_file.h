#pragma once

#include "scenegen/import/file_scene.h"

namespace dapple::scenegen {

/// Reads a PLY file, text or binary, of polygons or triangle strips, with its coordinates as doubles (see
/// addPolygonObject()). Throws the UsageErrors of importFile().
FileScene readPly(const std::filesystem::path& file, const Sidecar& sidecar);

}  // namespace dapple::scenegen
