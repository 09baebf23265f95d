#pragma once

#include "scenegen/scene.h"

#include <string>
#include <vector>

namespace dapple::scenegen {

struct SceneEntry {
    std::string name;
    std::string description;
};

/// Named recipes in scenegen/scenes/*.toml, sorted by name, each with the `description` it opens with.
std::vector<SceneEntry> listScenes();

/// The scene of that name (a recipe), or of a file: a recipe (.toml), GeoJSON footprints, or anything that Assimp opens.
/// `settings` are "key=value" overrides of a recipe's keys, which footprints have too. Its notes are warned about. The
/// result is validate()d.
/// Throws UsageError: unknown name (with the nearest), missing or damaged file, rejected recipe.
Scene loadScene(const std::string& nameOrFile, const std::vector<std::string>& settings = {});

}  // namespace dapple::scenegen
