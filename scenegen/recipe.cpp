#include "scenegen/recipe.h"

#include "base/config.h"
#include "base/detmath.h"
#include "base/error.h"
#include "base/random.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/lod/decimate.h"
#include "scenegen/placement/path.h"
#include "scenegen/placement/poisson.h"
#include "scenegen/plants/tree.h"
#include "scenegen/primitives.h"
#include "scenegen/terrain/ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

namespace dapple::scenegen {
namespace {

constexpr int kCardTexels = 256;
constexpr uint64_t kPlacementPurpose = 0x74726565, kWindPurpose = 0x77696e64;

struct SpeciesEntry {
    Species species;
    double share = 1;
    int individuals = 1;
    size_t triangles = 0;
    LeafMode leaves = LeafMode::polygon;
    int lod = 0;
    double keep = 1;
    glm::dvec2 scale{1};
    std::optional<glm::dvec2> position;  ///< of its one tree, which is not scattered
};

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
        seed_ = uint64_t(t_.integer("seed", 1, 0, int64_t{1} << 53));
        if (t_.has("origin")) scene_.origin = vec3(t_, "origin");
        readSun();
        readGround();
        readPrimitives();
        readPath();
        readWind();
        readSpecies();
        t_.finish();
        for (auto& [entry, line] : species_) plantSpecies(entry, *line);
        placeTrees();
        addWalkViews();
        if (scene_.views.empty()) t_.fail("view", "a scene needs at least one [[view]] or a [path]");
        return std::move(scene_);
    }

private:
    static glm::dvec3 vec3(base::ConfigTable& t, const char* key) {
        const std::vector<double> v = t.numbers(key, 3);
        return {v[0], v[1], v[2]};
    }

    static glm::vec3 albedo(base::ConfigTable& t, const glm::vec3& fallback) {
        if (!t.has("albedo")) return fallback;
        const glm::vec3 a(vec3(t, "albedo"));
        for (int i = 0; i < 3; ++i)
            if (a[i] < 0 || a[i] > 1) t.fail("albedo", "an albedo lies between 0 and 1");
        return a;
    }

    uint32_t addMaterial(Material material) {
        scene_.materials.push_back(std::move(material));
        return uint32_t(scene_.materials.size() - 1);
    }

    void readSun() {
        std::optional<base::ConfigTable> t = t_.table("sun");
        if (!t) return;
        scene_.sun.azimuth = t->number("azimuth", scene_.sun.azimuth, -360, 360);
        scene_.sun.elevation = t->number("elevation", scene_.sun.elevation, -90, 90);
        t->finish();
    }

    void readGround() {
        std::optional<base::ConfigTable> t = t_.table("ground");
        if (!t) return;
        GroundOptions options;
        options.size = t->number("size", options.size, 0.1, 100'000);
        options.undulation = t->number("undulation", 0, 0, 100);
        options.cells = int(t->integer("cells", options.cells, 1, 2000));
        options.seed = seed_;
        const glm::vec3 colour = albedo(*t, {0.20f, 0.17f, 0.10f});
        t->finish();
        groundSize_ = options.size;
        ground_.emplace(options);
        Mesh mesh = ground_->mesh();
        mesh.material = addMaterial({.name = "ground", .albedo = colour, .doubleSided = false});
        addInstanced("ground", std::move(mesh), glm::vec3(0), false);
    }

    void addInstanced(const std::string& name, Mesh mesh, const glm::vec3& position, bool casts) {
        Prototype prototype{name, {std::move(mesh)}, casts, false};
        prototype.closed = isClosed(prototype);
        scene_.prototypes.push_back(std::move(prototype));
        scene_.instances.push_back({.translation = position, .prototype = uint32_t(scene_.prototypes.size() - 1)});
    }

    void readPrimitives() {
        for (base::ConfigTable& t : t_.tables("primitive")) {
            const std::string kind = t.text("kind");
            const glm::vec3 position(vec3(t, "position"));
            Mesh mesh;
            if (kind == "box" || kind == "slab") {
                const glm::dvec3 size = vec3(t, "size");
                if (!(size.x > 0 && size.y > 0 && size.z > 0)) t.fail("size", "must be above 0");
                mesh = boxMesh(glm::vec3(size));
            } else if (kind == "sphere") {
                const double radius = t.number("radius", 1, 0.001, 10'000);
                mesh = sphereMesh(float(radius), int(t.integer("refine", 5, 0, 7)));
            } else {
                t.fail("kind", fmt::format("'{}' is none of box, sphere, slab", kind));
            }
            mesh.material = addMaterial({.name = kind, .albedo = albedo(t, {0.6f, 0.55f, 0.5f}), .doubleSided = false});
            t.finish();
            addInstanced(kind, std::move(mesh), position, true);
        }
    }

    void readWind() {
        std::optional<base::ConfigTable> t = t_.table("wind");
        if (!t) return;
        Wind wind;
        wind.strength = t->number("strength", 0.5, 0, 1);
        const auto [s, c] = base::det::sinCos(t->number("direction", 270, -360, 360) * base::det::kDegree);
        wind.direction = {-s, -c};
        wind.time = t->number("time", 0, 0, 1e6);
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
            if (!ground_) t_.fail("path", "a path needs a [ground] to run on");
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
            view.eye = {x, y, ground_->height(x, y) + path_.eyeHeight};
            // One looks along the way, at what is a few steps ahead rather than at one's feet.
            const double ahead = y + 0.12 * groundSize_;
            view.forward = glm::normalize(glm::dvec3(way_->x(ahead), ahead, ground_->height(way_->x(ahead), ahead) + 1.3 * path_.eyeHeight) - view.eye);
            walk.push_back(view);
        }
        scene_.views.insert(scene_.views.begin(), walk.begin(), walk.end());
    }

    void readSpecies() {
        for (base::ConfigTable& t : t_.tables("species")) {
            SpeciesEntry e;
            const std::string name = t.text("name");
            try {
                e.species = loadSpecies(name);
            } catch (const base::Error& error) {
                // A damaged species file names itself; an unknown name is this table's fault.
                if (std::string_view(error.what()).starts_with("unknown")) t.fail("name", error.what());
                throw;
            }
            e.share = t.number("share", 1, 1e-6, 1e6);
            e.individuals = int(t.integer("individuals", 1, 1, 1000));
            e.triangles = size_t(t.integer("triangles", 0, 0, 10'000'000));
            const std::string leaves = t.text("leaves", "polygon");
            if (leaves != "polygon" && leaves != "card" && leaves != "solid") t.fail("leaves", fmt::format("'{}' is none of polygon, card, solid", leaves));
            e.leaves = leaves == "card" ? LeafMode::card : leaves == "solid" ? LeafMode::solid : LeafMode::polygon;
            if (t.has("lod")) {
                e.lod = int(t.integer("lod", 0, 0, kLods - 1));
                if (!t.has("triangles")) e.triangles = e.species.triangles[size_t(e.lod)];
            }
            e.keep = t.number("keep", 1, 0.001, 1);
            if (t.has("position")) {
                const std::vector<double> p = t.numbers("position", 2);
                e.position = {p[0], p[1]};
            }
            if (t.has("scale")) {
                const std::vector<double> s = t.numbers("scale", 2);
                if (!(s[0] > 0 && s[1] >= s[0])) t.fail("scale", "must be [lo, hi] with 0 < lo ≤ hi");
                e.scale = {s[0], s[1]};
            }
            t.finish();
            species_.emplace_back(std::move(e), std::make_unique<base::ConfigTable>(std::move(t)));
        }
        if (species_.empty()) return;
        if (!ground_) t_.fail("species", "trees need a [ground] to stand on");
        const bool scattered = std::any_of(species_.begin(), species_.end(), [](const auto& s) { return !s.first.position; });
        if (scattered && !t_.has("trees")) t_.fail("trees", "is required with [[species]] that have no position");
        if (scattered) trees_ = size_t(t_.integer("trees", 0, 1, 100'000'000));
        spacing_ = t_.number("spacing", 1, 0, 100);
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
        prototypes_.emplace_back();
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
            prototype.moving = wind_.has_value();
            prototypes_.back().push_back(uint32_t(scene_.prototypes.size()));
            scene_.prototypes.push_back(std::move(prototype));
        }
    }

    void placeTrees() {
        for (size_t k = 0; k < species_.size(); ++k)
            if (const std::optional<glm::dvec2> p = species_[k].first.position)
                scene_.instances.push_back({.translation = glm::vec3(p->x, p->y, ground_->height(p->x, p->y)),
                                            .yaw = wind_ ? float(windYaw(prototypes_[k][0])) : 0, .prototype = prototypes_[k][0]});
        double shares = 0;
        for (const auto& [entry, line] : species_) shares += entry.position ? 0 : entry.share;
        std::vector<double> due(species_.size(), 0), radii;
        std::vector<Instance> trees;
        std::vector<double> crownRadius(scene_.prototypes.size());
        for (size_t i = 0; i < scene_.prototypes.size(); ++i) {
            const glm::vec3 half = scene_.prototypes[i].box().halfSize();
            crownRadius[i] = 0.5 * double(half.x + half.y);
        }
        for (size_t i = 0; i < trees_; ++i) {
            // Largest remainder: after n trees every species has its share to within one tree.
            for (size_t k = 0; k < due.size(); ++k) due[k] += species_[k].first.position ? -1 : species_[k].first.share / shares;
            const auto k = size_t(std::max_element(due.begin(), due.end()) - due.begin());
            due[k] -= 1;
            base::Random random(seed_, i, kPlacementPurpose);
            Instance tree;
            const std::vector<uint32_t>& individuals = prototypes_[k];
            tree.prototype = individuals[size_t(random.next() * float(individuals.size()))];
            tree.yaw = float(2 * base::det::kPi * random.next());
            if (wind_) tree.yaw = float(windYaw(tree.prototype));
            const glm::dvec2 range = species_[k].first.scale;
            tree.scale = float(range.x + (range.y - range.x) * random.next());
            trees.push_back(tree);
            radii.push_back(spacing_ * crownRadius[tree.prototype] * tree.scale);
        }
        if (trees.empty()) return;
        const auto allowed = [&](const glm::dvec2& p) { return !way_ || way_->distance(p) >= 0.5 * path_.width; };
        const double half = 0.48 * groundSize_;
        const std::vector<glm::dvec2> places = poissonDisks(radii, half, seed_, allowed);
        for (size_t i = 0; i < trees.size(); ++i) {
            trees[i].translation = glm::vec3(glm::dvec3(places[i], ground_->height(places[i].x, places[i].y)));
            scene_.instances.push_back(trees[i]);
        }
    }

    base::ConfigTable& t_;
    Scene scene_;
    uint64_t seed_ = 1;
    double groundSize_ = 0, spacing_ = 1;
    std::optional<Ground> ground_;
    std::optional<Path> way_;
    PathEntry path_;
    std::optional<Wind> wind_;
    std::set<std::string> viewNames_;
    std::vector<std::pair<SpeciesEntry, std::unique_ptr<base::ConfigTable>>> species_;
    std::vector<std::vector<uint32_t>> prototypes_;  // of each species, its individuals
    size_t trees_ = 0;
};

}  // namespace

Scene readRecipe(const std::filesystem::path& path, const std::vector<std::string>& settings) {
    base::ConfigTable table = base::ConfigTable::parseFile(path);
    for (const std::string& setting : settings) table.set(setting);
    Scene scene = RecipeReader(table, path.stem().string()).read();
    scene.source = path.string();
    return scene;
}

std::string recipeDescription(const std::filesystem::path& path) { return base::ConfigTable::parseFile(path).text("description"); }

}  // namespace dapple::scenegen
