#include "scenegen/recipe.h"

#include "base/config.h"
#include "base/detmath.h"
#include "base/error.h"
#include "base/log.h"
#include "base/random.h"
#include "scenegen/city/city.h"
#include "scenegen/city/courtyard.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/lod/decimate.h"
#include "scenegen/lod/grid.h"
#include "scenegen/placement/forest.h"
#include "scenegen/placement/path.h"
#include "scenegen/plants/tree.h"
#include "scenegen/primitives.h"
#include "scenegen/recipe_species.h"
#include "scenegen/require_memory.h"
#include "scenegen/terrain/ground.h"
#include "scenegen/terrain/terrain.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <set>

namespace dapple::scenegen {
namespace {

constexpr int kCardTexels = 256;
constexpr size_t kBytesPerCell = 110;  ///< of ground: a vertex, two triangles, and the copy that the GPU is handed
constexpr size_t kBytesPerTree = 140;  ///< while a forest is placed: sown and standing instances, grid, radii
constexpr uint64_t kWindPurpose = 0x77696e64;

struct PathEntry {
    int views = 0;
    double width = 0, eyeHeight = 0;
    View lens;  ///< its fovY, near and far
};

class RecipeReader {
public:
    RecipeReader(base::ConfigTable& table, const std::string& name) : t_(table) { scene_.name = name; }

    Scene read() {
        t_.text("description");
        const std::string opens = t_.has("opens") ? t_.text("opens") : "";
        seed_ = uint64_t(t_.integer("seed", 1, 0, int64_t{1} << 53));
        if (t_.has("origin")) scene_.origin = vec3(t_, "origin");
        area_ = t_.number("scale", 1, 1e-4, 1e4);
        time_ = t_.number("time", 0, 0, 1e6);
        radius_ = t_.number("radius", 0, 0, 1e9);
        readSuns();
        readGround();
        readClearings();
        uint64_t index = 0;
        for (base::ConfigTable& t : t_.tables("primitive")) addPrimitive(scene_, t, base::mix64(seed_ + index++));
        if (std::optional<base::ConfigTable> t = t_.table("city")) city_ = readCity(*t, area_);
        if (std::optional<base::ConfigTable> t = t_.table("courtyard")) courtyard_ = readCourtyard(*t, area_);
        readPath();
        readWind();
        readSpecies();
        t_.finish();
        for (auto& [entry, line] : species_) plantSpecies(entry, *line);
        placeTrees();
        addWalkViews();
        if (terrain_) addTerrain(scene_, *terrain_);
        if (city_) addCity(scene_, *city_, seed_);
        if (courtyard_) addCourtyard(scene_, *courtyard_, seed_);
        scene_.moveTo(time_);
        for (Prototype& prototype : scene_.prototypes)
            for (Mesh& mesh : prototype.meshes) snapToGrid(mesh);
        if (scene_.views.empty()) t_.fail("view", "a scene needs at least one [[view]], a [path], a [city] or a [courtyard]");
        if (!opens.empty()) openWith(opens);
        if (radius_ > 0) keepAbout(scene_.views.front().eye);
        return std::move(scene_);
    }

private:
    static glm::dvec3 vec3(base::ConfigTable& t, const char* key) {
        const std::vector<double> v = t.numbers(key, 3);
        return {v[0], v[1], v[2]};
    }

    /// The view that is used where none is named comes first.
    void openWith(const std::string& name) {
        const auto view = std::ranges::find(scene_.views, name, &View::name);
        if (view == scene_.views.end()) t_.fail("opens", "names no view of this scene");
        std::rotate(scene_.views.begin(), view, view + 1);
    }

    /// The same scene and views, with less of it around: what is left out begins farther from `eye` than the radius.
    void keepAbout(const glm::dvec3& eye) {
        std::vector<base::Box> boxes;
        for (const Prototype& prototype : scene_.prototypes) boxes.push_back(prototype.box());
        keepInstances(scene_, [&](size_t i) {
            const Instance& instance = scene_.instances[i];
            const base::Box box = instanceBox(boxes[instance.prototype], instance);
            return !box.empty() && glm::distance(glm::dvec2(glm::clamp(eye, glm::dvec3(box.lo), glm::dvec3(box.hi))), glm::dvec2(eye)) <= radius_;
        });
    }

    uint32_t addMaterial(Material material) {
        scene_.materials.push_back(std::move(material));
        return uint32_t(scene_.materials.size() - 1);
    }

    void readSuns() {
        const auto place = [](base::ConfigTable& t, Sun& sun) {
            sun.azimuth = t.number("azimuth", sun.azimuth, -360, 360);
            sun.elevation = t.number("elevation", sun.elevation, -90, 90);
        };
        if (std::optional<base::ConfigTable> t = t_.table("sun")) {
            place(*t, scene_.sun);
            t->finish();
        }
        for (base::ConfigTable& t : t_.tables("further_sun")) {
            if (scene_.furtherSuns.size() + 1 == kMostSuns) t.fail("azimuth", fmt::format("a scene has at most {} suns", kMostSuns));
            Sun sun;
            place(t, sun);
            sun.strength = t.number("strength", 1, 1e-3, 100);
            t.finish();
            scene_.furtherSuns.push_back(sun);
        }
    }

    void readGround() {
        if (std::optional<base::ConfigTable> t = t_.table("terrain")) {
            if (t_.has("ground")) t_.fail("ground", "a scene has a [ground] or a [terrain], not both");
            terrain_ = readTerrain(*t, seed_, area_);
            scene_.notes = terrain_->notes.lines();
            groundSize_ = terrain_->size();
            const HeightField& field = terrain_->field;
            height_ = [&field](const glm::dvec2& p) { return field.height(p.x, p.y); };
            slope_ = [&field](const glm::dvec2& p) { return field.slope(p.x, p.y); };
            return;
        }
        std::optional<base::ConfigTable> t = t_.table("ground");
        if (!t) return;
        GroundOptions options;
        const double side = std::sqrt(area_);
        options.size = t->number("size", options.size, 1e-4, 1e6) * side;
        options.undulation = t->number("undulation", 0, 0, 100);
        options.cells = std::max(1, int(std::lround(double(t->integer("cells", options.cells, 1, 2000)) * side)));
        options.seed = seed_;
        const double cells = double(options.cells) * options.cells;
        requireMemory(*t, "cells", fmt::format("{0} × {0} cells of ground", options.cells), cells, kBytesPerCell);
        const glm::vec3 colour = readAlbedo(*t, {0.20f, 0.17f, 0.10f});
        t->finish();
        groundSize_ = options.size;
        const Ground ground(options);
        height_ = [ground](const glm::dvec2& p) { return ground.height(p.x, p.y); };
        slope_ = [ground](const glm::dvec2& p) {
            const glm::dvec3 n = ground.normal(p.x, p.y);
            return std::sqrt(n.x * n.x + n.y * n.y) / n.z;
        };
        Mesh mesh = ground.mesh();
        mesh.material = addMaterial({.name = "ground", .albedo = colour, .doubleSided = false});
        scene_.prototypes.push_back({"ground", {std::move(mesh)}, false, false});
        scene_.instances.push_back({.prototype = uint32_t(scene_.prototypes.size() - 1)});
    }

    void readWind() {
        std::optional<base::ConfigTable> t = t_.table("wind");
        if (!t) return;
        Wind wind;
        wind.strength = t->number("strength", 0.5, 0, 1);
        const auto [s, c] = base::det::sinCos(t->number("direction", 270, -360, 360) * base::det::kDegree);
        wind.direction = {-s, -c};
        wind.time = time_;
        t->finish();
        if (wind.strength > 0) wind_ = wind;
    }

    /// With wind, all trees of one individual stand alike: only then does one bent shape serve them all.
    double windYaw(size_t prototype) const { return 2 * base::det::kPi * base::Random(seed_, prototype, kWindPurpose).next(); }

    std::optional<Wind> windOn(size_t prototype) const {
        if (!wind_) return {};
        Wind wind = *wind_;
        const auto [s, c] = base::det::sinCos(windYaw(prototype));
        wind.direction = {c * wind_->direction.x + s * wind_->direction.y, c * wind_->direction.y - s * wind_->direction.x};
        return wind;
    }

    static void readLens(base::ConfigTable& t, View& view) {
        view.fovY = t.number("fovY", view.fovY, 1, 170);
        view.near = t.number("near", view.near, 1e-6, 1e9);
        view.far = t.number("far", view.far, 1e-6, 1e9);
        if (!(view.near < view.far)) t.fail("far", "must be beyond near");
    }

    void readPath() {
        if (std::optional<base::ConfigTable> t = t_.table("path")) {
            path_.views = int(t->integer("views", 4, 1, 10'000));
            path_.width = t->number("width", 3, 0, 1000);
            path_.eyeHeight = t->number("eyeHeight", 1.7, 0.01, 1000);
            readLens(*t, path_.lens);
            t->finish();
            if (!height_) t_.fail("path", "a path needs a [ground] or a [terrain] to run on");
            way_.emplace(groundSize_, seed_);
        }
        for (base::ConfigTable& t : t_.tables("view")) {
            View view;
            view.name = t.text("name");
            view.eye = vec3(t, "eye");
            const glm::dvec3 ahead = vec3(t, "target") - view.eye;
            if (!(glm::length(ahead) > 1e-9)) t.fail("target", "must not be the eye");
            view.forward = glm::normalize(ahead);
            // Straight up or down the vertical is no up vector; north is.
            if (std::abs(view.forward.z) > 0.9999) view.up = {0, 1, 0};
            readLens(t, view);
            t.finish();
            if (!viewNames_.insert(view.name).second) t.fail("name", "two views have this name");
            scene_.views.push_back(view);
        }
    }

    void addWalkViews() {
        std::vector<View> walk;
        for (int i = 0; i < path_.views; ++i) {
            View view = path_.lens;
            view.name = fmt::format("walk{}", i);
            if (viewNames_.contains(view.name)) t_.fail("path", "a [[view]] has the name " + view.name + " already");
            const double y = (-0.46 + 0.7 * i / path_.views) * groundSize_;
            const double x = way_->x(y);
            view.eye = {x, y, height_({x, y}) + path_.eyeHeight};
            // One looks along the way, at what is a few steps ahead rather than at one's feet.
            const double ahead = y + 0.12 * groundSize_;
            view.forward = glm::normalize(glm::dvec3(way_->x(ahead), ahead, height_({way_->x(ahead), ahead}) + 1.3 * path_.eyeHeight) - view.eye);
            walk.push_back(view);
        }
        scene_.views.insert(scene_.views.begin(), walk.begin(), walk.end());
    }

    void readSpecies() {
        for (base::ConfigTable& t : t_.tables("species")) {
            SpeciesEntry e = readSpeciesEntry(t);
            species_.emplace_back(std::move(e), std::make_unique<base::ConfigTable>(std::move(t)));
        }
        if (species_.empty()) return;
        if (!height_) t_.fail("species", "trees need a [ground] or a [terrain] to stand on");
        const bool scattered = std::any_of(species_.begin(), species_.end(), [](const auto& s) { return !s.first.position; });
        if (scattered && !t_.has("trees")) t_.fail("trees", "is required with [[species]] that have no position");
        if (scattered) trees_ = size_t(t_.integer("trees", 0, 1, 4'000'000'000));
        trees_ = std::max<size_t>(scattered ? 1 : 0, size_t(std::llround(double(trees_) * area_)));
        requireMemory(t_, "trees", fmt::format("{} trees", trees_), double(trees_), kBytesPerTree);
        spacing_ = t_.number("spacing", 1, 0, 100);
        crowding_ = t_.boolean("selfThinning", false) ? Crowding::thin : Crowding::shrink;
    }

    /// Adds the prototypes and materials of one species.
    void plantSpecies(SpeciesEntry& e, const base::ConfigTable& line) {
        const Species& s = e.species;
        const uint32_t bark = addMaterial({.name = s.name + " bark", .albedo = s.barkAlbedo, .doubleSided = false});
        Material leaf{.name = s.name + " leaves", .albedo = s.leaves.albedo, .specular = 0.12f, .shininess = 24};
        if (e.leaves == LeafMode::card) {
            leaf.texture = int(scene_.textures.size());
            leaf.alphaTested = true;
            scene_.textures.push_back({s.name + " card", drawCard(s, kCardTexels)});
        }
        const uint32_t leaves = addMaterial(leaf);
        for (int i = 0; i < e.individuals; ++i) {
            Tree tree;
            try {
                tree = growTree(s, {base::mix64(seed_ + uint64_t(i)), e.triangles, e.leaves, e.lod, windOn(scene_.prototypes.size())});
            } catch (const base::Error& error) {
                line.fail("triangles", error.what());
            }
            tree.bark.material = bark;
            tree.leaves.material = leaves;
            Prototype prototype{e.individuals == 1 ? s.name : fmt::format("{} {}", s.name, i), {std::move(tree.bark), std::move(tree.leaves)}, true, false};
            std::erase_if(prototype.meshes, [](const Mesh& m) { return m.indices.empty(); });
            prototype = decimate(prototype, e.keep);
            prototype.closed = isClosed(prototype);
            const glm::vec3 half = prototype.box().halfSize();
            e.stand.individuals.push_back(uint32_t(scene_.prototypes.size()));
            e.stand.crownRadii.push_back(0.5 * double(half.x + half.y));
            prototype.moving = wind_.has_value();
            prototype.transmittance = e.transmittance;
            scene_.prototypes.push_back(std::move(prototype));
        }
    }

    void readClearings() {
        for (base::ConfigTable& t : t_.tables("clearing")) {
            const std::vector<double> centre = t.numbers("centre", 2);
            clearings_.emplace_back(centre[0], centre[1], t.number("radius", 10, 0, 1e6));
            t.finish();
        }
    }

    void placeTrees() {
        std::vector<Stand> stands;
        for (const auto& [entry, line] : species_) {
            if (const std::optional<glm::dvec2> p = entry.position)
                scene_.instances.push_back({.translation = glm::vec3(p->x, p->y, height_(*p)),
                                            .yaw = wind_ ? float(windYaw(entry.stand.individuals[0])) : 0, .prototype = entry.stand.individuals[0]});
            else
                stands.push_back(entry.stand);
        }
        if (stands.empty()) return;
        Site site{0.48 * groundSize_, height_, slope_, [this](const glm::dvec2& p) {
                      if (way_ && way_->distance(p) < 0.5 * path_.width) return false;
                      return std::none_of(clearings_.begin(), clearings_.end(), [&](const glm::dvec3& c) { return glm::distance(glm::dvec2(c), p) < c.z; });
                  }};
        std::vector<Instance> trees = plantForest(trees_, spacing_, crowding_, seed_, stands, site);
        for (Instance& tree : trees)
            if (wind_) tree.yaw = float(windYaw(tree.prototype));
        scene_.instances.insert(scene_.instances.end(), trees.begin(), trees.end());
    }

    base::ConfigTable& t_;
    Scene scene_;
    uint64_t seed_ = 1;
    double area_ = 1;  ///< the recipe's scale
    double radius_ = 0;  ///< metres about the first view's eye, seen from above, beyond which nothing stands; 0: no limit
    double time_ = 0;  ///< seconds
    double groundSize_ = 0, spacing_ = 1;
    std::function<double(const glm::dvec2&)> height_, slope_;  ///< of the ground or the terrain; empty without
    std::optional<Terrain> terrain_;
    std::vector<glm::dvec3> clearings_;  ///< centre x, y, radius
    Crowding crowding_ = Crowding::shrink;
    std::optional<City> city_;
    std::optional<Courtyard> courtyard_;
    std::optional<Path> way_;
    PathEntry path_;
    std::optional<Wind> wind_;
    std::set<std::string> viewNames_;
    std::vector<std::pair<SpeciesEntry, std::unique_ptr<base::ConfigTable>>> species_;
    size_t trees_ = 0;
};

Scene readTable(base::ConfigTable table, const std::filesystem::path& path, const std::vector<std::string>& settings) {
    for (const std::string& setting : settings) table.set(setting);
    try {
        Scene scene = RecipeReader(table, path.stem().string()).read();
        scene.source = path.string();
        for (const std::string& note : scene.notes) base::logWarning(fmt::format("{}: {}", scene.source, note));
        return scene;
    } catch (const std::bad_alloc&) {
        throw base::UsageError(path.string() + ": there is no memory for a scene of these counts and this scale; ask for less");
    }
}

}  // namespace

Scene readRecipe(const std::filesystem::path& path, const std::vector<std::string>& settings) {
    return readTable(base::ConfigTable::parseFile(path), path, settings);
}

Scene readFootprintScene(const std::filesystem::path& geojson, const std::vector<std::string>& settings) {
    const std::string file = nlohmann::json(geojson.filename().string()).dump();  // quoted as TOML quotes, too
    const std::string text = fmt::format("description = {0}\n[sun]\n[city]\nfootprints = {0}\n", file);
    return readTable(base::ConfigTable::parseText(text, geojson.string()), geojson, settings);
}

std::string recipeDescription(const std::filesystem::path& path) { return base::ConfigTable::parseFile(path).text("description"); }

}  // namespace dapple::scenegen
