#include "scenegen/library.h"

#include "base/error.h"
#include "base/file.h"
#include "base/file_name.h"
#include "base/log.h"
#include "scenegen/import/file_kind.h"
#include "scenegen/import/import.h"
#include "scenegen/recipe.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

void refuseSettings(const std::string& name, const std::vector<std::string>& settings) {
    if (settings.empty()) return;
    throw base::UsageError(fmt::format("setting '{}': only recipes have settings; {} is read from a file", settings[0], name));
}

Scene readFile(const std::string& name, const fs::path& file, const std::vector<std::string>& settings) {
    switch (fileKind(file)) {
        case FileKind::recipe: return readRecipe(file, settings);
        case FileKind::footprints: return readFootprintScene(file, settings);
        case FileKind::sidecar:
            throw base::UsageError(file.string() + ": says how to read a scene file of the same name, and is no scene "
                                                   "itself; open that file");
        case FileKind::scene: break;
    }
    refuseSettings(name, settings);
    return importFile(file);
}

}  // namespace

std::vector<SceneEntry> listScenes() {
    std::vector<SceneEntry> scenes;
    for (const auto& entry : fs::directory_iterator(base::homeFolder() / "scenegen/scenes"))
        if (entry.path().extension() == ".toml") scenes.push_back({entry.path().stem().string(), recipeDescription(entry.path())});
    std::sort(scenes.begin(), scenes.end(), [](const SceneEntry& a, const SceneEntry& b) { return a.name < b.name; });
    return scenes;
}

Scene loadScene(const std::string& nameOrFile, const std::vector<std::string>& settings) {
    const fs::path given(nameOrFile), recipe = base::homeFolder() / "scenegen/scenes" / (nameOrFile + ".toml");
    const bool named = !given.empty() && !given.has_extension() && !given.has_parent_path();
    const auto read = [&](const fs::path& file) {
        base::noteInput(file);
        return readFile(nameOrFile, file, settings);
    };
    Scene scene;
    if (named && fs::exists(recipe)) {
        scene = readRecipe(recipe, settings);
        scene.source = nameOrFile;
    } else if (isRealScene(nameOrFile)) {
        scene = read(realScenePath(nameOrFile));
    } else if (named && !fs::exists(given)) {
        std::vector<std::string> known;
        for (const auto& entries : {listScenes(), listRealScenes()})
            for (const SceneEntry& entry : entries) known.push_back(entry.name);
        throw base::UsageError(base::unknownName("scene", nameOrFile, known));
    } else {
        scene = read(given);
    }
    dropBadInstances(scene);
    validate(scene);
    return scene;
}

}  // namespace dapple::scenegen
