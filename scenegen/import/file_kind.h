#pragma once

#include <filesystem>

namespace dapple::scenegen {

enum class FileKind {
    recipe,      ///< TOML that describes a scene (scenegen/recipe.h)
    sidecar,     ///< TOML that says how to read the scene file beside it (scenegen/import/sidecar.h)
    footprints,  ///< GeoJSON: .geojson, .geojsonl, .geojsons, .json
    scene,       ///< everything else
};

/// What a file is. TOML files are told apart by their keys, whatever they are called. Throws UsageError when there is
/// no such file, naming one of almost this name if there is one, and when it is a pipe or a device.
FileKind fileKind(const std::filesystem::path& file);

/// Whether NAME.toml beside NAME.ext is its sidecar, and no recipe that happens to have its name.
bool hasSidecar(const std::filesystem::path& file);

}  // namespace dapple::scenegen
