#pragma once

#include "scenegen/import/file_scene.h"

namespace dapple::scenegen {

/// Reads a Wavefront OBJ file with its MTL libraries. Coordinates are doubles until the whole metres of each object
/// that lies far off are its node's, so that georeferenced files keep their shape. Throws the UsageErrors of
/// importFile().
FileScene readObj(const std::filesystem::path& file, const Sidecar& sidecar);

}  // namespace dapple::scenegen
