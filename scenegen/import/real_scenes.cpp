#include "base/error.h"
#include "base/file.h"
#include "scenegen/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace dapple::scenegen {
namespace {

struct RealScene {
    const char* name;
    const char* file;  ///< relative to the cache folder, as the script leaves it
    RealSceneScript fetch;
    const char* description;
    int downloadMb;
};

constexpr std::array<RealScene, 3> kRealScenes{{
    {"astana", "real/astana/astana.toml", {"scenegen/import/fetch_astana", ""}, "24.5 km square of Astana, OpenStreetMap's 32,000 buildings (ODbL) extruded to their heights, 530,000 triangles", 16},
    {"buildings", "real/buildings/buildings_2.blend", {"scenegen/import/fetch_real", "buildings"}, "village with trees, MORSE simulator (BSD-3), 458,000 triangles", 82},
    {"forza", "real/forza/forza.ac", {"scenegen/import/fetch_real", "forza"}, "race track with tree walls and stands, TORCS (Free Art), 72,000 triangles", 333},
}};

std::string command(const RealScene& scene) { return fmt::format("{}{}{}", scene.fetch.file, *scene.fetch.argument ? " " : "", scene.fetch.argument); }

const RealScene* find(const std::string& name) {
    const auto* it = std::ranges::find(kRealScenes, name, &RealScene::name);
    return it == kRealScenes.end() ? nullptr : it;
}

const RealScene& known(const std::string& name) {
    if (const RealScene* scene = find(name)) return *scene;
    std::vector<std::string> names;
    for (const RealScene& s : kRealScenes) names.emplace_back(s.name);
    throw base::UsageError(base::unknownName("real scene", name, names));
}

}  // namespace

bool isRealScene(const std::string& name) { return find(name) != nullptr; }

std::vector<SceneEntry> listRealScenes() {
    std::vector<SceneEntry> entries;
    for (const RealScene& scene : kRealScenes) {
        const bool fetched = std::filesystem::exists(base::cacheFolder() / scene.file);
        const std::string state = fetched ? "fetched" : fmt::format("{} downloads {} MB", command(scene), scene.downloadMb);
        entries.push_back({scene.name, fmt::format("{} [{}]", scene.description, state)});
    }
    return entries;
}

RealSceneScript realSceneScript(const std::string& name) { return known(name).fetch; }

std::filesystem::path realScenePath(const std::string& name) {
    const RealScene& scene = known(name);
    const auto path = base::cacheFolder() / scene.file;
    if (!std::filesystem::exists(path))
        throw base::UsageError(fmt::format("scene '{}' is not fetched yet; run {} ({} MB)", name, command(scene), scene.downloadMb));
    return path;
}

}  // namespace dapple::scenegen
