#include "scenegen/city/courtyard.h"

#include "base/detmath.h"
#include "base/random.h"
#include "scenegen/city/arcade.h"
#include "scenegen/city/assembly.h"
#include "scenegen/city/facade.h"
#include "scenegen/plants/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen {
namespace {
using namespace city;

constexpr double kWall = 0.7;  // metres, thickness
constexpr uint64_t kFlagPurpose = 0x666c6167, kPlantPurpose = 0x706c616e74;
constexpr glm::vec3 kCloth[] = {{0.42f, 0.03f, 0.025f}, {0.03f, 0.07f, 0.30f}, {0.05f, 0.20f, 0.06f}, {0.55f, 0.38f, 0.06f}};

/// One side of the court: local x along it, local y away from the court.
struct Side {
    glm::dvec2 middle, along, outwards;
    int bays;

    double half() const { return 0.5 * bays * kArcadeBay; }
    glm::dvec2 at(double x, double y) const { return middle + along * x + outwards * y; }
};

class Builder {
public:
    Builder(Scene& scene, const Courtyard& court, uint64_t seed)
        : scene_(scene), court_(court), seed_(seed), hx_(0.5 * court.bays * kArcadeBay), hy_(0.5 * court.across * kArcadeBay),
          sides_{{{{0, -hy_}, {-1, 0}, {0, -1}, court.bays}, {{hx_, 0}, {0, -1}, {1, 0}, court.across}, {{0, hy_}, {1, 0}, {0, 1}, court.bays}, {{-hx_, 0}, {0, 1}, {-1, 0}, court.across}}} {
        stone_ = addMaterial(scene, "limestone", {0.56f, 0.50f, 0.40f});
        plaster_ = addMaterial(scene, "plaster", {0.60f, 0.47f, 0.31f});
        trim_ = addMaterial(scene, "trim", {0.62f, 0.58f, 0.50f});
        marble_ = addMaterial(scene, "dark marble", {0.10f, 0.095f, 0.09f}, 0.25f, 50);
        tiles_ = addMaterial(scene, "roof tiles", {0.36f, 0.145f, 0.08f});
        clay_ = addMaterial(scene, "terracotta", {0.38f, 0.17f, 0.09f});
        earth_ = addMaterial(scene, "earth", {0.07f, 0.05f, 0.035f});
        metal_ = addMaterial(scene, "lead", {0.20f, 0.21f, 0.22f}, 0.2f, 24);
    }

    void build() {
        addGround();
        addArcades();
        addRoof();
        addWalls();
        addCloth();
        addFountainsAndPlants();
        addViews();
    }

private:
    void place(uint32_t prototype, const Side& side, double x, double y = 0, double z = 0) { addInstance(scene_, prototype, {side.at(x, y), z}, side.along); }

    /// The part of a side's plan from y0 to y1 away from its columns, up to the mitres with its neighbours; local.
    static Region strip(double half, double y0, double y1) { return {{{-half - y0, y0}, {half + y0, y0}, {half + y1, y1}, {-half - y1, y1}}, {0, 0, 0, 0}}; }

    /// Sides of one length share what `make(half)` gives.
    template <class Make>
    void placeOnSides(const char* name, Make make) {
        std::array<uint32_t, 2> prototypes{addPrototype(scene_, fmt::format("{} along", name), make(hx_)), addPrototype(scene_, fmt::format("{} across", name), make(hy_))};
        for (size_t i = 0; i < 4; ++i) place(prototypes[i % 2], sides_[i], 0);
    }

    void addGround() {
        const double far = hx_ + 40, wide = hy_ + 40;
        Mesh land, bed;
        addBox(land, {-far, -wide, -1}, {far, wide, -0.12});
        addBox(bed, {-hx_ - 0.5, -hy_ - 0.5, -0.5}, {hx_ + 0.5, hy_ + 0.5, -0.03});
        addInstance(scene_, addPrototype(scene_, "ground", {of(std::move(land), addMaterial(scene_, "land", {0.20f, 0.18f, 0.13f})), of(std::move(bed), earth_)}, false), glm::dvec3(0), {1, 0});
        // Flags in three shades, four ways of laying them.
        constexpr glm::vec3 kShades[] = {{0.34f, 0.31f, 0.26f}, {0.29f, 0.265f, 0.225f}, {0.38f, 0.345f, 0.29f}};
        std::array<uint32_t, 3> shades;
        for (size_t i = 0; i < 3; ++i) shades[i] = addMaterial(scene_, fmt::format("flags {}", i), kShades[i]);
        std::vector<Mesh> flags(3);
        base::Random random(seed_, 0, kFlagPurpose);
        for (int j = 0; j < 5; ++j)
            for (int i = 0; i < 5; ++i) {
                const glm::dvec2 lo = glm::dvec2(i, j) * 0.8 - 2.0 + 0.006;
                const double shade = random.next(), height = 0.004 * random.next();
                addBox(flags[size_t(3 * shade)], {lo, -0.2}, {lo + 0.788, height});
            }
        for (size_t i = 0; i < 3; ++i) flags[i].material = shades[i];
        const uint32_t prototype = addPrototype(scene_, "flags", std::move(flags), false);
        for (int j = 0; j < court_.across; ++j)
            for (int i = 0; i < court_.bays; ++i) {
                constexpr glm::dvec2 kTurns[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
                const auto turn = size_t(4 * random.next());
                addInstance(scene_, prototype, {(i + 0.5) * kArcadeBay - hx_, (j + 0.5) * kArcadeBay - hy_, 0}, kTurns[turn]);
            }
    }

    void addArcades() {
        Mesh pier;
        addBox(pier, {-0.52, -0.52, -0.1}, {0.52, 0.52, 0.55});
        addBox(pier, {-0.45, -0.45, 0.5}, {0.45, 0.45, 9.03});
        addFrustum(pier, {-0.46, -0.46, 0.46, 0.46}, 2.7, {-0.56, -0.56, 0.56, 0.56}, 2.94);
        addFrustum(pier, {-0.46, -0.46, 0.46, 0.46}, 7.36, {-0.53, -0.53, 0.53, 0.53}, 7.54);
        const uint32_t pillar = addPrototype(scene_, "pier", {of(std::move(pier), stone_)});
        const uint32_t column = addPrototype(scene_, "column", {of(lowerColumn(), trim_)}), slender = addPrototype(scene_, "slender column", {of(upperColumn(), trim_)});
        const uint32_t arch = addPrototype(scene_, "arch", {of(lowerArch(), stone_)}), pair = addPrototype(scene_, "pair of arches", {of(upperArches(), stone_)});
        const uint32_t across = addPrototype(scene_, "transverse arch", {of(transverseArch(), plaster_)}), rail = addPrototype(scene_, "balustrade", {of(balustrade(), trim_)});
        Mesh bracket, tie, chequer;
        addFrustum(bracket, {-0.24, -0.12, 0.24, 0.05}, 2.25, {-0.3, -0.3, 0.3, 0.05}, 2.96);
        addBox(tie, {-0.1, -0.1, 8.55}, {0.1, kArcadeBay + 0.1, 8.8});
        const uint32_t console = addPrototype(scene_, "console", {of(std::move(bracket), trim_)}), beam = addPrototype(scene_, "tie beam", {of(std::move(tie), addMaterial(scene_, "timber", {0.12f, 0.07f, 0.04f}))});
        for (int j = 0; j < 8; ++j)
            for (int i = j % 2; i < 8; i += 2) addBox(chequer, {-2.0 + 0.5 * i + 0.004, 0.5 * j + 0.004, -0.05}, {-1.5 + 0.5 * i - 0.004, 0.5 * j + 0.496, 0.006});
        const uint32_t floor = addPrototype(scene_, "chequer", {of(std::move(chequer), marble_)}, false);
        for (const Side& side : sides_) {
            place(pillar, side, -side.half());
            for (int i = 0; i < side.bays; ++i) {
                const double x = (i + 0.5) * kArcadeBay - side.half(), left = x - 0.5 * kArcadeBay;
                place(arch, side, x), place(pair, side, x), place(rail, side, x), place(slender, side, x);
                place(floor, side, x, 0, kArcadeFloor), place(floor, side, x, 0, kGalleryFloor);
                if (i > 0) place(column, side, left), place(slender, side, left);
                // From every column to the wall, and from the corners too.
                for (const double end : {left, left + kArcadeBay}) {
                    if (end > left && i + 1 < side.bays) continue;
                    addInstance(scene_, across, {side.at(end, 0.5 * kArcadeBay), 0}, side.outwards);
                    place(beam, side, end), place(console, side, end, kArcadeBay);
                }
            }
            // The square behind the corner.
            place(floor, side, side.half() + 0.5 * kArcadeBay, 0, kArcadeFloor), place(floor, side, side.half() + 0.5 * kArcadeBay, 0, kGalleryFloor);
        }
        placeOnSides("floors", [&](double half) {
            Mesh floors, mouldings;
            addPrism(floors, strip(half, -0.62, kArcadeBay + 0.1), -0.2, kArcadeFloor);
            addPrism(floors, strip(half, -0.2, kArcadeBay + 0.1), kGalleryFloor - 0.25, kGalleryFloor);
            // Cornices, of layers that stand out more and more.
            for (const auto& [z, out, height] : {std::array{4.72, 0.34, 0.09}, {4.8, 0.42, 0.08}, {4.87, 0.56, 0.12}, {4.98, 0.62, 0.1}, {8.5, 0.3, 0.12}, {8.61, 0.38, 0.09}}) addPrism(mouldings, strip(half, -out, 0.1), z, z + height);
            return std::vector{of(std::move(floors), stone_), of(std::move(mouldings), trim_)};
        });
    }

    void addRoof() {
        const uint32_t bay = addPrototype(scene_, "roof tiles", {of(roofTiles(), tiles_)});
        const uint32_t corner[2] = {addPrototype(scene_, "roof tiles right", {of(cornerTiles(false), tiles_)}), addPrototype(scene_, "roof tiles left", {of(cornerTiles(true), tiles_)})};
        for (const Side& side : sides_) {
            for (int i = 0; i < side.bays; ++i) place(bay, side, (i + 0.5) * kArcadeBay - side.half());
            place(corner[0], side, side.half()), place(corner[1], side, -side.half());
        }
        placeOnSides("roof", [&](double half) {
            Mesh deck, gutter;
            const Line eaves{{0, -kOverhang}, {1, 0}};
            addPrism(deck, strip(half, -kOverhang, kRidge), {.floor = kEaves - 0.18, .roof = kEaves, .eaves = &eaves, .slope = kPitch, .floorSlope = kPitch});
            // The valley with the next side, and the ridge.
            const double rise = kPitch * (kRidge + kOverhang);
            const auto across = [&](double t, double z) {
                const glm::dvec2 p(half - kOverhang + t * (kRidge + kOverhang), -kOverhang + t * (kRidge + kOverhang)), side(0.14, -0.14);
                const double h = kEaves + t * rise + z;
                return std::array{glm::dvec3(p - side, h), glm::dvec3(p + side, h)};
            };
            const auto a = across(-0.01, -0.1), b = across(-0.01, 0.07), c = across(1, -0.1), d = across(1, 0.07);
            const std::array low{a[0], a[1], b[1], b[0]}, high{c[0], c[1], d[1], d[0]};
            addLoft(gutter, low, high);
            addPrism(gutter, strip(half, kRidge - 0.22, kRidge + 0.12), kEaves + rise - 0.15, kEaves + rise + 0.14);
            return std::vector{of(std::move(deck), clay_), of(std::move(gutter), metal_)};
        });
    }

    void addWalls() {
        const uint32_t glass = addMaterial(scene_, "window glass", {0.03f, 0.035f, 0.042f}, 0.5f, 90), frame = addMaterial(scene_, "window frames", {0.14f, 0.09f, 0.05f});
        const Fittings fittings{true, true, true};
        const std::array rows{Row{-0.3, kGalleryFloor, {1.15, 1.55, 1.95, 0.25}, fittings}, Row{kGalleryFloor, 8.8, {1.2, 0.5, 1.0, 0.25}, fittings}, Row{8.8, kWallTop, {}, {}}};
        std::array blank = rows;
        for (Row& row : blank) row.opening = {};
        placeOnSides("wall", [&](double half) {
            Parts parts;
            const double x = half + kArcadeBay, bays = std::floor(2 * x / kArcadeBay + 0.5);
            const std::array<glm::dvec2, 4> outline{{{-x, kArcadeBay}, {x, kArcadeBay}, {x + kWall, kArcadeBay + kWall}, {-x - kWall, kArcadeBay + kWall}}};
            const std::array columns{int(bays), 1, int(bays), 1};
            for (size_t i = 0; i < 4; ++i) addWall(parts, outline[i], outline[(i + 1) % 4], columns[i], i % 2 ? std::span<const Row>(blank) : rows);
            addLids(parts.wall, outline, columns, -0.3, kWallTop);
            return std::vector{of(std::move(parts.wall), plaster_), of(std::move(parts.trim), frame), of(std::move(parts.glass), glass)};
        });
    }

    void addCloth() {
        std::array<uint32_t, std::size(kCloth)> banners, curtains;
        for (size_t i = 0; i < banners.size(); ++i) {
            const uint32_t cloth = addMaterial(scene_, fmt::format("cloth {}", i), kCloth[i]);
            banners[i] = addPrototype(scene_, fmt::format("banner {}", i), {of(banner(), cloth)});
            curtains[i] = addPrototype(scene_, fmt::format("curtain {}", i), {of(curtain(), cloth), of(curtainRod(), metal_)});
        }
        for (size_t s = 0; s < 4; ++s)
            for (int i = 0; i < sides_[s].bays; ++i) {
                const double x = (i + 0.5) * kArcadeBay - sides_[s].half();
                if (i % 3 == 1) place(banners[size_t(i / 3 + int(s)) % banners.size()], sides_[s], x);
                else if (i % 3 == 2) place(curtains[size_t(i / 3 + int(s) + 1) % curtains.size()], sides_[s], x);
            }
    }

    struct Plant {
        uint32_t prototype;
        double radius, height;  ///< of the crown, and of all
    };

    std::vector<Plant> grow(const char* name, size_t triangles, int lod, int individuals) {
        const Species species = loadSpecies(name);
        const uint32_t bark = addMaterial(scene_, fmt::format("{} bark", name), species.barkAlbedo);
        const uint32_t leaf = addMaterial(scene_, fmt::format("{} leaves", name), species.leaves.albedo, 0.12f, 24);
        std::vector<Plant> plants;
        for (int i = 0; i < individuals; ++i) {
            Tree tree = growTree(species, {.seed = base::mix64(seed_ + uint64_t(i)), .triangles = triangles, .leaves = LeafMode::solid, .lod = lod});
            const uint32_t prototype = addPrototype(scene_, fmt::format("{} {}", name, i), {of(std::move(tree.bark), bark), of(std::move(tree.leaves), leaf)});
            const base::Box box = scene_.prototypes.back().box();
            plants.push_back({prototype, double(std::max({-box.lo.x, -box.lo.y, box.hi.x, box.hi.y})), double(box.hi.z)});
        }
        return plants;
    }

    void addPlant(const std::vector<Plant>& kinds, const glm::dvec3& foot, double radius, double height, base::Random& random) {
        const Plant& plant = kinds[size_t(random.next() * float(kinds.size()))];
        const double turn = 2 * base::det::kPi * random.next(), size = 0.85 + 0.15 * random.next();
        scene_.instances.push_back({glm::vec3(foot), float(size * std::min(radius / plant.radius, height / plant.height)), float(turn), plant.prototype});
    }

    void addFountainsAndPlants() {
        Fountain parts = fountain();
        const uint32_t water = addMaterial(scene_, "water", {0.02f, 0.045f, 0.045f}, 0.6f, 100);
        const uint32_t prototype = addPrototype(scene_, "fountain", {of(std::move(parts.stone), trim_), of(std::move(parts.water), water)});
        const uint32_t potted = addPrototype(scene_, "pot", {of(pot(), clay_), of(earthOf(0.25, 0.565), earth_)});
        const uint32_t boxed = addPrototype(scene_, "planter", {of(planter(), stone_), of(earthOf(0.6, 0.5), earth_)});
        // One fountain for about nine bays; trees in two rows, where none is near.
        const int fountains = std::max(1, int(std::floor(court_.bays / 9.0 + 0.5)));
        const auto fountainX = [&](int i) { return (2 * i + 1) * hx_ / fountains - hx_; };
        for (int i = 0; i < fountains; ++i) addInstance(scene_, prototype, {fountainX(i), 0, 0}, {1, 0});
        std::vector<Plant> trees, shrubs, ferns;
        if (court_.plants > 0) trees = grow("oak", 2 * court_.plants, 1, 3), shrubs = grow("shrub", court_.plants / 2, 1, 3), ferns = grow("fern", court_.plants / 2, 1, 2);
        base::Random random(seed_, 0, kPlantPurpose);
        for (int i = 1; i < court_.bays; i += 2)
            for (const double y : {-0.5 * hy_, 0.5 * hy_}) {
                const double x = i * kArcadeBay - hx_;
                addInstance(scene_, boxed, {x, y, 0}, {1, 0});
                if (!trees.empty()) addPlant(trees, {x, y, 0.47}, 1.9, 4.6, random);
            }
        for (const Side& side : sides_)
            for (int i = 1; i < side.bays; ++i) {
                place(potted, side, i * kArcadeBay - side.half(), -1.05);
                if (!shrubs.empty()) addPlant(i % 2 ? shrubs : ferns, {side.at(i * kArcadeBay - side.half(), -1.05), 0.55}, 0.75, 1.3, random);
            }
    }

    void addViews() {
        const double y = hy_ + 0.5 * kArcadeBay, step = std::min(kArcadeBay, hx_);
        const auto add = [&](const char* name, const glm::dvec3& eye, const glm::dvec3& target) {
            scene_.views.push_back({.name = name, .eye = eye, .forward = glm::normalize(target - eye), .fovY = court_.fovY, .near = 0.1, .far = std::max(250.0, 6 * hx_)});
        };
        add("fly0", {-hx_ + std::min(6.0, hx_ - 3.1), court_.across % 2 ? 0 : -0.5 * kArcadeBay, 1.65}, {0.4 * hx_, 0.14 * hy_, 3.1});
        add("fly1", {-hx_ - 0.5, -y, 1.8}, {hx_, -y + 0.35, 2.1});
        add("fly2", {hx_ - 0.45 * step, -hy_ - 3.2, 1.75}, {hx_ - 1.3 * step, hy_, 3.6});
        add("fly3", {-hx_ + 0.55 * step, y - 0.3, kGalleryFloor + 1.6}, {hx_, y - 1.1, kGalleryFloor + 1.2});
        add("fly4", {hx_ - 1.5, 0.3 * hy_, 6.4}, {-0.3 * hx_, -0.2 * hy_, 3.2});
        add("fly5", {-hx_ + 0.5, -hy_ + 0.5, 13.5}, {0.1 * hx_, 0.1 * hy_, 1});
        const double reach = hx_ + hy_ + 8;
        add("above", {-0.62 * reach, -0.8 * reach, 0.75 * reach + 6}, {0, 0, 2});
    }

    Scene& scene_;
    const Courtyard& court_;
    uint64_t seed_;
    double hx_, hy_;  ///< half sides of the court: the lines of the columns
    std::array<Side, 4> sides_;
    uint32_t stone_, plaster_, trim_, marble_, tiles_, clay_, earth_, metal_;
};

}  // namespace

Courtyard readCourtyard(base::ConfigTable& table, double scale) {
    Courtyard court;
    if (scale < 0.01 || scale > 64) table.fail("bays", fmt::format("a courtyard is built at a scale from 0.01 to 64, not {}", scale));
    court.bays = std::max(2, int(std::lround(double(table.integer("bays", court.bays, 2, 1000)) * scale)));
    court.across = int(table.integer("across", court.across, 2, 1000));
    court.plants = size_t(table.integer("plants", int64_t(court.plants), 0, 1'000'000));
    court.fovY = table.number("fovY", court.fovY, 1, 170);
    table.finish();
    return court;
}

void addCourtyard(Scene& scene, const Courtyard& courtyard, uint64_t seed) { Builder(scene, courtyard, seed).build(); }

}  // namespace dapple::scenegen
