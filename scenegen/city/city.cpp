#include "scenegen/city/city.h"

#include "base/file.h"
#include "base/random.h"
#include "scenegen/city/assembly.h"
#include "scenegen/city/footprints.h"
#include "scenegen/city/furniture.h"
#include "scenegen/city/house.h"
#include "scenegen/city/tower.h"
#include "scenegen/city/views.h"
#include "scenegen/lod/view_distance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace dapple::scenegen {
namespace {
using namespace city;

constexpr uint64_t kLookPurpose = 0x6c6f6f6b, kYardPurpose = 0x79617264;
constexpr double kTile = 64;  // metres along a side of a tile of the ground
constexpr double kViennaArea = 0.9e6, kManhattanArea = 7.7e6;  // m² at scale 1

struct Colour {
    const char* name;
    glm::vec3 albedo;
};
// Linear, of weathered paint and stone (a fresh white wall has 0.8, asphalt 0.05 to 0.12).
constexpr Colour kStucco[] = {{"stucco ochre", {0.56f, 0.42f, 0.22f}}, {"stucco cream", {0.60f, 0.54f, 0.42f}}, {"stucco grey", {0.44f, 0.43f, 0.41f}},
                              {"stucco rose", {0.55f, 0.40f, 0.34f}}, {"stucco green", {0.42f, 0.46f, 0.36f}}, {"stucco white", {0.66f, 0.64f, 0.60f}},
                              {"stucco blue", {0.40f, 0.45f, 0.49f}}, {"stucco brown", {0.42f, 0.31f, 0.21f}}};
constexpr Colour kTiles[] = {{"tiles red", {0.29f, 0.115f, 0.07f}}, {"tiles brown", {0.20f, 0.105f, 0.075f}}, {"slate", {0.12f, 0.125f, 0.13f}}};
constexpr Colour kTowerWalls[] = {{"brick red", {0.28f, 0.105f, 0.07f}}, {"brick brown", {0.19f, 0.12f, 0.085f}}, {"brick buff", {0.46f, 0.36f, 0.24f}},
                                  {"limestone", {0.52f, 0.48f, 0.40f}}, {"limestone grey", {0.42f, 0.41f, 0.38f}}, {"limestone warm", {0.50f, 0.43f, 0.34f}},
                                  {"concrete", {0.36f, 0.36f, 0.35f}}, {"concrete white", {0.56f, 0.55f, 0.52f}}, {"concrete dark", {0.22f, 0.22f, 0.22f}},
                                  {"mullions dark", {0.07f, 0.075f, 0.08f}}, {"mullions bronze", {0.14f, 0.10f, 0.07f}}, {"mullions steel", {0.34f, 0.36f, 0.38f}}};

class CityBuilder {
public:
    CityBuilder(Scene& scene, const City& city, uint64_t seed)
        : scene_(scene), city_(city), seed_(seed),
          plan_(layOut(city.style, city.scale * (city.style == Style::vienna ? kViennaArea : kManhattanArea), seed)), radius_(0.5 * std::sqrt(plan_.ground.area())) {
        glass_ = addMaterial(scene, "window glass", {0.03f, 0.035f, 0.042f}, 0.5f, 90);
        frames_ = addMaterial(scene, "window frames", {0.50f, 0.48f, 0.44f});
        iron_ = addMaterial(scene, "dark iron", {0.07f, 0.075f, 0.07f}, 0.2f, 24);
    }

    void build() {
        addGround();
        const FurnitureOptions furniture{.seed = seed_, .treeTriangles = city_.treeTriangles, .traffic = city_.traffic, .nearDetail = city_.nearDetail, .night = city_.night};
        addViews(scene_, plan_, city_.views, city_.fovY);
        if (city_.style == Style::vienna) buildVienna();
        else buildManhattan();
        addFurniture(scene_, plan_, std::move(yardTrees_), furniture);
        if (city_.night) scene_.sun.elevation = std::min(scene_.sun.elevation, -12.0);
    }

private:
    void addGround() {
        const uint32_t asphalt = addMaterial(scene_, "asphalt", {0.085f, 0.085f, 0.088f}), stone = addMaterial(scene_, "pavement", {0.27f, 0.26f, 0.245f});
        const uint32_t kerbstone = addMaterial(scene_, "kerbstone", {0.36f, 0.35f, 0.33f}), lawn = addMaterial(scene_, "lawn", {0.085f, 0.125f, 0.045f});
        const uint32_t land = addMaterial(scene_, "land", {0.15f, 0.15f, 0.09f});
        addRoadway(asphalt, land);
        for (size_t b = 0; b < plan_.blocks.size(); ++b) {
            const Block& block = plan_.blocks[b];
            Mesh kerbs, pavement, grass;
            addPrism(kerbs, block.kerb, -0.1, kPavement - 0.01);
            Region flags = block.kerb;
            for (size_t i = 0; i < flags.size(); ++i) flags = clip(flags, block.kerb.edge(i).moved(0.25), 0);
            addPrism(pavement, flags, -0.05, kPavement);
            Region green = block.lot;
            const double border = block.park ? 0.6 : kWingDepth + 2.5;
            for (size_t i = 0; i < block.lot.size() && !green.empty(); ++i) green = clip(green, block.lot.edge(i).moved(border), 0);
            if (!green.empty() && (block.park || (city_.style == Style::vienna && orientedBox(green).width() > 8))) {
                addPrism(grass, green, 0, kPavement + 0.04);
                plantYard(green, b);
            }
            place(addPrototype(scene_, fmt::format("pavement {}", b), {of(kerbs, kerbstone), of(pavement, stone), of(grass, lawn)}));
        }
    }

    /// In square tiles, so that what is in sight of it can be told. They receive only: the roadway is the lowest thing there is.
    void addRoadway(uint32_t asphalt, uint32_t land) {
        glm::dvec2 far(0);
        for (const glm::dvec2& p : plan_.ground.corners) far = glm::max(far, glm::abs(p));
        const glm::ivec2 last(glm::ceil((far + 100.0) / kTile - 0.5));
        std::optional<uint32_t> whole;
        for (int y = -last.y; y <= last.y; ++y)
            for (int x = -last.x; x <= last.x; ++x) {
                const glm::dvec2 centre = kTile * glm::dvec2(x, y);
                Region road = rectangle(centre - kTile / 2, centre + kTile / 2, 0);
                const double all = road.area();
                for (size_t i = 0; i < plan_.ground.size() && !road.empty(); ++i) road = clip(road, plan_.ground.edge(i), 0);
                const bool inner = !road.empty() && road.area() > all - 1e-6;
                if (!inner || !whole) {
                    for (glm::dvec2& p : road.corners) p -= centre;
                    Mesh around, asphalted;
                    if (!inner) addBox(around, glm::dvec3(-glm::dvec2(kTile / 2), -1.0), glm::dvec3(glm::dvec2(kTile / 2), -0.12));
                    if (!road.empty()) addPrism(asphalted, road, -0.5, 0);
                    const uint32_t tile = addPrototype(scene_, fmt::format("ground {} {}", x, y), {of(around, land), of(asphalted, asphalt)}, false);
                    if (inner) whole = tile;
                    addInstance(scene_, tile, {centre, 0}, {1, 0});
                } else {
                    addInstance(scene_, *whole, {centre, 0}, {1, 0});
                }
            }
    }

    Detail detailAt(const glm::dvec3& p) const { return city_.nearDetail > 0 && viewDistance(scene_, p) > city_.nearDetail ? Detail::far : Detail::near; }

    void place(uint32_t prototype) { addInstance(scene_, prototype, glm::dvec3(0), {1, 0}); }

    void plantYard(const Region& green, uint64_t number) {
        const Extent box = orientedBox(green);
        const glm::dvec2 u = box.direction, v{-u.y, u.x};
        base::Random random(seed_, number, kYardPurpose);
        for (double y = box.acrossLo; y < box.acrossHi; y += 9)
            for (double x = box.alongLo; x < box.alongHi; x += 9) {
                const double dx = random.next(), dy = random.next(), grows = random.next();
                const glm::dvec2 p = u * (x + 7 * dx) + v * (y + 7 * dy);
                if (grows < 0.6 && green.contains(p, 1.5)) yardTrees_.push_back({{p, kPavement}, 4.2});
            }
    }

    void buildVienna() {
        const uint32_t stone = addMaterial(scene_, "ashlar", {0.52f, 0.48f, 0.41f}), zinc = addMaterial(scene_, "zinc", {0.30f, 0.32f, 0.33f}, 0.15f, 20);
        const uint32_t timber = addMaterial(scene_, "timber", {0.10f, 0.055f, 0.03f});
        std::array<uint32_t, std::size(kStucco)> stucco;
        std::array<uint32_t, std::size(kTiles)> tiles;
        for (size_t i = 0; i < stucco.size(); ++i) stucco[i] = addMaterial(scene_, kStucco[i].name, kStucco[i].albedo);
        for (size_t i = 0; i < tiles.size(); ++i) tiles[i] = addMaterial(scene_, kTiles[i].name, kTiles[i].albedo);
        const auto addBalcony = [&](Detail detail) {
            Parts balcony = balconyModule(detail);
            return addPrototype(scene_, "balcony", {of(std::move(balcony.trim), stone), of(std::move(balcony.roof), iron_)});
        };
        const uint32_t balconies[2] = {addBalcony(Detail::near), city_.nearDetail > 0 ? addBalcony(Detail::far) : 0};
        std::map<std::array<int, 5>, uint32_t> bays;
        std::map<std::array<int, 2>, uint32_t> dormers;

        for (size_t b = 0; b < plan_.blocks.size(); ++b) {
            const Block& block = plan_.blocks[b];
            if (block.park) continue;
            const uint64_t blockSeed = base::mix64(seed_ ^ base::mix64(b + 1));
            const base::Random look(seed_, b, kLookPurpose);
            const int usual = 4 + int(2.3f * look.uniform(0));
            std::map<uint32_t, Mesh> meshes;  // by material
            const std::vector<Region> parcels = subdivide(block.lot, {380, 820, 13, 0.35, 0}, blockSeed);
            for (size_t p = 0; p < parcels.size(); ++p) {
                const base::Random r(blockSeed, p, kLookPurpose);
                House house{std::clamp(usual + int(3 * r.uniform(0)) - 1, 4, 6), int(r.uniform(1) * float(kHouseStyles)), base::mix64(blockSeed + p)};
                const auto colour = size_t(r.uniform(2) * float(stucco.size())), tile = size_t(r.uniform(3) * r.uniform(4) * float(tiles.size()));
                Parts parts;
                std::vector<Placed> modules;
                addHouse(parts, parcels[p], block.lot, house, &modules);
                append(meshes[stucco[colour]], parts.wall);
                append(meshes[stone], parts.trim);
                append(meshes[tiles[tile]], parts.roof);
                for (const Placed& m : modules) {
                    const Detail detail = detailAt(m.position);
                    uint32_t prototype = balconies[detail == Detail::far];
                    if (m.what == Placed::bay) {
                        const auto [at, isNew] = bays.try_emplace({house.style, house.floors, int(colour), int(m.kind), int(detail)}, 0);
                        if (isNew) {
                            Parts bay = bayModule(house, m.kind, detail);
                            at->second = addPrototype(scene_, fmt::format("bay {} of {} floors, {}", house.style, house.floors, kStucco[colour].name),
                                                      {of(std::move(bay.wall), stucco[colour]), of(std::move(bay.trim), frames_), of(std::move(bay.glass), glass_), of(std::move(bay.roof), timber)});
                        }
                        prototype = at->second;
                    } else if (m.what == Placed::dormer) {
                        const auto [at, isNew] = dormers.try_emplace({int(colour), int(tile)}, 0);
                        if (isNew) {
                            Parts dormer = dormerModule();
                            at->second = addPrototype(scene_, "dormer", {of(std::move(dormer.wall), stucco[colour]), of(std::move(dormer.trim), frames_), of(std::move(dormer.glass), glass_), of(std::move(dormer.roof), zinc)});
                        }
                        prototype = at->second;
                    }
                    addInstance(scene_, prototype, m.position, m.direction);
                }
            }
            std::vector<Mesh> ofBlock;
            for (auto& [material, mesh] : meshes) ofBlock.push_back(of(std::move(mesh), material));
            place(addPrototype(scene_, fmt::format("block {}", b), std::move(ofBlock)));
        }
    }

    void buildManhattan() {
        const uint32_t stone = addMaterial(scene_, "cast stone", {0.44f, 0.42f, 0.37f}), wood = addMaterial(scene_, "tank wood", {0.15f, 0.095f, 0.06f});
        const uint32_t curtain = addMaterial(scene_, "curtain glass", {0.035f, 0.055f, 0.075f}, 0.7f, 120);
        std::vector<uint32_t> walls;
        for (const Colour& c : kTowerWalls) walls.push_back(addMaterial(scene_, c.name, c.albedo));
        struct Tower {
            uint32_t wall = 0;
            std::map<Detail, uint32_t> prototypes;
        };
        std::map<TowerKind, Tower> towers;
        for (size_t b = 0; b < plan_.blocks.size(); ++b) {
            const Block& block = plan_.blocks[b];
            if (block.park) continue;
            const uint64_t blockSeed = base::mix64(seed_ ^ base::mix64(b + 1));
            const std::vector<Region> parcels = subdivide(block.lot, {420, 2600, 4 * kBay, 0.5, 2 * kBay}, blockSeed);
            for (size_t p = 0; p < parcels.size(); ++p) {
                const base::Random r(blockSeed, p, kLookPurpose);
                const auto [kind, direction] = kindOf(parcels[p], r);
                const glm::dvec3 place(parcels[p].centroid(), 0);
                const Detail detail = detailAt(place);
                const auto [tower, isNewKind] = towers.try_emplace(kind);
                if (isNewKind) tower->second.wall = walls[size_t(kind.style) * 3 + towers.size() % 3];
                const auto [at, isNew] = tower->second.prototypes.try_emplace(detail, 0);
                if (isNew) {
                    Parts parts = towerParts(kind, seed_, detail);
                    const uint32_t wall = tower->second.wall;
                    at->second = addPrototype(scene_, fmt::format("tower {} × {} bays, style {}", kind.width, kind.depth, kind.style),
                                              {of(std::move(parts.wall), wall), of(std::move(parts.trim), kind.style == 3 ? wall : stone),
                                               of(std::move(parts.glass), kind.style == 3 ? curtain : glass_), of(std::move(parts.roof), wood)});
                }
                addInstance(scene_, at->second, place, direction);
            }
        }
    }

    /// What stands on a parcel of whole bays, and the direction of its front.
    std::pair<TowerKind, glm::dvec2> kindOf(const Region& parcel, const base::Random& r) const {
        // Fronts look to the avenue or street that they have most of.
        size_t front = 0;
        double longest = -1;
        for (size_t i = 0; i < 4; ++i)
            if (parcel.labels[i] >= 0 && parcel.length(i) > longest) longest = parcel.length(i), front = i;
        const auto bays = [&](size_t i) { return int(std::floor(parcel.length(i) / kBay + 0.5)); };
        TowerKind kind;
        kind.width = bays(front), kind.depth = bays((front + 1) % 4);
        kind.right = parcel.labels[(front + 1) % 4] >= 0;
        kind.rear = parcel.labels[(front + 2) % 4] >= 0;
        kind.left = parcel.labels[(front + 3) % 4] >= 0;
        const bool small = std::min(kind.width, kind.depth) < 6;
        // Towers cluster about two centres, as round Grand Central and Wall Street.
        const auto nearness = [&](const glm::dvec2& centre) {
            const glm::dvec2 d = (parcel.centroid() - centre * radius_) / (0.45 * radius_);
            return 1 / (1 + 2 * glm::dot(d, d));
        };
        const double tall = r.uniform(1) * (0.55 + std::max(nearness({0.25, 0.2}), nearness({-0.45, -0.5})));
        kind.rise = small ? int(3 * r.uniform(1)) : tall > 0.8 ? 2 : tall > 0.42 ? 1 : 0;
        // Two styles for each size: the city shares its buildings, and its memory stays small.
        constexpr int kStylesOf[4][2] = {{0, 1}, {1, 2}, {0, 3}, {1, 0}};
        const float style = r.uniform(0);
        kind.style = small ? (style < 0.75f ? 0 : 1) : kStylesOf[(kind.width / 2 + kind.depth / 2 + kind.rise) % 4][style < 0.5f];
        return {kind, parcel.edge(front).direction};
    }

    Scene& scene_;
    const City& city_;
    uint64_t seed_;
    Plan plan_;
    double radius_;  // half the side of a square of the city's area, metres
    std::vector<TreePlace> yardTrees_;
    uint32_t glass_ = 0, frames_ = 0, iron_ = 0;
};

}  // namespace

City readCity(base::ConfigTable& table, double scale) {
    City city;
    if (table.has("footprints")) {
        city.footprints = table.path("footprints");
        city.projected = table.boolean("projected", false);
        city.nearDetail = table.number("nearDetail", 0, 0, 1e6);
        city.views = int(table.integer("views", 6, 1, 60));
        city.fovY = table.number("fovY", 60, 1, 170);
        table.finish();
        return city;
    }
    const std::string style = table.text("style", "vienna");
    if (style != "vienna" && style != "manhattan") table.fail("style", fmt::format("'{}' is none of vienna, manhattan", style));
    city.style = style == "vienna" ? Style::vienna : Style::manhattan;
    if (scale < 1.0 / 1024 || scale > 64) table.fail("style", fmt::format("a city is grown at a scale from 1/1024 to 64, not {}", scale));
    city.scale = scale;
    city.treeTriangles = size_t(table.integer("trees", 2000, 0, 1'000'000));
    city.traffic = table.number("traffic", 0, 0, 95);
    city.night = table.boolean("night", false);
    city.nearDetail = table.number("nearDetail", 0, 0, 1e6);
    city.views = int(table.integer("views", 6, 1, 1000));
    city.fovY = table.number("fovY", 60, 1, 170);
    table.finish();
    return city;
}

void addCity(Scene& scene, const City& city, uint64_t seed) {
    if (city.footprints.empty()) return CityBuilder(scene, city, seed).build();
    addFootprints(scene, parseFootprints(base::readFile(city.footprints), city.footprints.string(), city.projected), city.views, city.fovY, seed);
}

}  // namespace dapple::scenegen
