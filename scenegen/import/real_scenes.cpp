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
    const char* file;  ///< relative to the cache folder, as scenegen/import/fetch_real leaves it
    const char* description;
    int downloadMb;
};

constexpr std::array<RealScene, 2> kRealScenes{{
    {"buildings", "real/buildings/buildings_2.blend", "village with trees, MORSE simulator (BSD-3), 458,000 triangles", 82},
    {"forza", "real/forza/forza.ac", "race track with tree walls and stands, TORCS (Free Art), 72,000 triangles", 333},
}};

const RealScene* find(const std::string& name) {
    const auto* it = std::ranges::find(kRealScenes, name, &RealScene::name);
    return it == kRealScenes.end() ? nullptr : it;
}

}  // namespace

bool isRealScene(const std::string& name) { return find(name) != nullptr; }

std::vector<SceneEntry> listRealScenes() {
    std::vector<SceneEntry> entries;
    for (const RealScene& scene : kRealScenes) {
        const bool fetched = std::filesystem::exists(base::cacheFolder() / scene.file);
        const std::string state = fetched ? "fetched" : fmt::format("scenegen/import/fetch_real {} downloads {} MB", scene.name, scene.downloadMb);
        entries.push_back({scene.name, fmt::format("{} [{}]", scene.description, state)});
    }
    return entries;
}

std::filesystem::path realScenePath(const std::string& name) {
    const RealScene* scene = find(name);
    if (!scene) {
        std::vector<std::string> known;
        for (const RealScene& s : kRealScenes) known.emplace_back(s.name);
        throw base::UsageError(base::unknownName("real scene", name, known));
    }
    const auto path = base::cacheFolder() / scene->file;
    if (!std::filesystem::exists(path))
        throw base::UsageError(fmt::format("scene '{}' is not fetched yet; run scenegen/import/fetch_real {} ({} MB)", name, name, scene->downloadMb));
    return path;
}

}  // namespace dapple::scenegen
