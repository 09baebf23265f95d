#include "base/detmath.h"
#include "base/log.h"
#include "base/random.h"
#include "scenegen/city/assembly.h"
#include "scenegen/city/footprints.h"
#include "scenegen/city/house.h"
#include "scenegen/city/solid.h"
#include "scenegen/city/triangulate.h"
#include "scenegen/views/pick_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace dapple::scenegen::city {
namespace {

constexpr double kCell = 250;  // metres: what is culled together
constexpr uint64_t kViewPurpose = 0x76696577, kColourPurpose = 0x636f6c;
constexpr glm::vec3 kWalls[] = {{0.50f, 0.46f, 0.38f}, {0.56f, 0.53f, 0.48f}, {0.42f, 0.40f, 0.37f}, {0.45f, 0.33f, 0.24f}, {0.58f, 0.50f, 0.36f}, {0.35f, 0.36f, 0.37f}};

/// Corners moved inwards from both edges.
Ring withJoint(const Ring& ring, double joint) {
    Ring out;
    for (size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 a = glm::normalize(ring[i] - ring[(i + ring.size() - 1) % ring.size()]), b = glm::normalize(ring[(i + 1) % ring.size()] - ring[i]);
        const glm::dvec2 na{-a.y, a.x}, nb{-b.y, b.x};
        out.push_back(ring[i] + joint * (na + nb) / std::max(0.2, 1 + glm::dot(na, nb)));
    }
    return out;
}

/// How far one sees from `p` along `direction`, up to `limit`; 0 within a building.
double sight(const std::vector<const Footprint*>& near, const glm::dvec2& p, const glm::dvec2& direction, double limit) {
    for (const Footprint* f : near)
        for (const Ring& ring : f->rings)
            for (size_t i = 0; i < ring.size(); ++i) {
                const glm::dvec2 a = ring[i] - p, d = ring[(i + 1) % ring.size()] - ring[i];
                const double det = direction.x * -d.y + d.x * direction.y;
                if (det == 0) continue;
                const double t = (a.x * -d.y + d.x * a.y) / det, s = (direction.x * a.y - direction.y * a.x) / det;
                if (s >= 0 && s <= 1 && t > 0) limit = std::min(limit, t);
            }
    return limit;
}

/// By (x, y) in cells.
using Cells = std::map<std::pair<int, int>, std::vector<const Footprint*>>;

/// The best of many spots in the open, looking where one sees farthest; and `above`, from the south-west over the middle of all built volume.
void addViews(Scene& scene, const Cells& cells, const glm::dvec2& half, int views, double fovY, uint64_t seed) {
    glm::dvec3 middle(0);
    double mass = 0;
    for (const auto& [at, buildings] : cells)
        for (const Footprint* f : buildings) {
            const double volume = f->height * twiceArea(f->rings[0]);
            middle += volume * glm::dvec3(f->rings[0][0], 0.5 * f->height), mass += volume;
        }
    middle /= mass;
    const double reach = std::min(1200.0, std::max(half.x, half.y));
    std::vector<View> spots;
    for (uint64_t i = 0; i < 200; ++i) {
        const base::Random random(seed, i, kViewPurpose);
        const glm::dvec2 p = glm::dvec2(middle) + 1.6 * reach * glm::dvec2(random.uniform(0) - 0.5, random.uniform(1) - 0.5);
        std::vector<const Footprint*> near;
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                if (const auto cell = cells.find({int(std::floor(p.x / kCell)) + x, int(std::floor(p.y / kCell)) + y}); cell != cells.end()) near.insert(near.end(), cell->second.begin(), cell->second.end());
        bool inside = false;
        for (const Footprint* f : near) inside = inside || contains(f->rings[0], p);
        if (inside) continue;
        glm::dvec2 best(1, 0);
        double longest = 0, nearest = kCell;
        for (int k = 0; k < 16; ++k) {
            const base::det::SinCos a = base::det::sinCos(base::det::kPi * k / 8);
            const double d = sight(near, p, {a.cos, a.sin}, kCell);
            nearest = std::min(nearest, d);
            if (d > longest && d < kCell) longest = d, best = {a.cos, a.sin};
        }
        if (nearest < 2.5) continue;
        View view{.name = "", .eye = {p, 1.7}, .forward = glm::normalize(glm::dvec3(best, 0.1)), .fovY = fovY, .near = 0.3, .far = std::max(400.0, reach)};
        spots.push_back(view);
    }
    std::vector<View> walk = pickViews(scene, spots, size_t(views));
    for (size_t i = 0; i < walk.size(); ++i) {
        walk[i].name = fmt::format("walk{}", i);
        scene.views.push_back(std::move(walk[i]));
    }
    View above{.name = "above", .eye = middle + glm::dvec3(-0.75, -0.85, 0.55) * reach, .fovY = fovY, .near = 1, .far = 6 * reach};
    above.forward = glm::normalize(middle - above.eye);
    scene.views.push_back(above);
}

}  // namespace

Mesh footprintPrism(const Footprint& footprint, double joint) {
    std::vector<Ring> rings;
    for (const Ring& ring : footprint.rings) rings.push_back(withJoint(ring, joint));
    const std::vector<std::array<uint32_t, 3>> triangles = triangulate(rings);
    Mesh mesh;
    if (triangles.empty()) return mesh;
    const double bottom = footprint.base > 0 ? footprint.base : -0.5;
    for (const bool top : {false, true}) {
        const auto base = uint32_t(mesh.positions.size());
        for (const Ring& ring : rings)
            for (const glm::dvec2& p : ring) {
                mesh.positions.emplace_back(p.x, p.y, top ? footprint.height : bottom);
                mesh.normals.emplace_back(0, 0, top ? 1 : -1);
            }
        for (const auto& t : triangles)
            for (const uint32_t v : {t[0], top ? t[1] : t[2], top ? t[2] : t[1]}) mesh.indices.push_back(base + v);
    }
    for (const Ring& ring : rings)
        for (size_t i = 0; i < ring.size(); ++i) {
            const glm::dvec2 a = ring[i], b = ring[(i + 1) % ring.size()];
            addFace(mesh, {{a, bottom}, {b, bottom}, {b, footprint.height}, {a, footprint.height}});
        }
    return mesh;
}

void addFootprints(Scene& scene, const Footprints& footprints, int views, double fovY, uint64_t seed) {
    glm::dvec2 half(0);
    Cells cells;
    for (const Footprint& f : footprints.buildings) {
        for (const glm::dvec2& p : f.rings[0]) half = glm::max(half, glm::abs(p));
        cells[{int(std::floor(f.rings[0][0].x / kCell)), int(std::floor(f.rings[0][0].y / kCell))}].push_back(&f);
    }
    Mesh ground;
    addBox(ground, {-half - 60.0, -1.0}, {half + 60.0, 0.0});
    const uint32_t earth = addMaterial(scene, "ground", {0.16f, 0.155f, 0.14f});
    addInstance(scene, addPrototype(scene, "ground", {of(std::move(ground), earth)}, false), glm::dvec3(0), {1, 0});
    std::array<uint32_t, std::size(kWalls)> walls;
    for (size_t i = 0; i < walls.size(); ++i) walls[i] = addMaterial(scene, fmt::format("wall {}", i), kWalls[i]);

    uint64_t number = 0;
    size_t lost = 0;
    for (const auto& [at, buildings] : cells) {
        // Positions relative to the cell: floats then hold a fortieth of a millimetre.
        const glm::dvec3 corner(kCell * at.first, kCell * at.second, 0);
        std::vector<Mesh> meshes(walls.size());
        for (const Footprint* building : buildings) {
            Footprint local = *building;
            for (Ring& ring : local.rings)
                for (glm::dvec2& p : ring) p -= glm::dvec2(corner);
            // Outlines that overlap may share corners too: no two nearby have the same joint.
            const double joint = kJoint * (1 + 0.1 * double(number % 16));
            Mesh prism = footprintPrism(local, joint);
            if (prism.indices.empty()) prism = footprintPrism(local, joint / 32);  // thin places
            lost += prism.indices.empty();
            append(meshes[size_t(base::Random(seed, number++, kColourPurpose).next() * float(walls.size()))], prism);
        }
        for (size_t i = 0; i < meshes.size(); ++i) meshes[i].material = walls[i];
        addInstance(scene, addPrototype(scene, fmt::format("buildings {} {}", at.first, at.second), std::move(meshes)), corner, {1, 0});
    }
    Notes notes = footprints.notes;
    if (lost > 0) notes.add("outlines too thin for walls of their own are left out", "", lost);
    for (std::string& note : notes.lines()) scene.notes.push_back(std::move(note));
    if (footprints.withoutHeight > 0)
        base::logInfo(fmt::format("{} buildings; {} without a height stand {} m high", footprints.buildings.size() - lost,
                                  footprints.withoutHeight, kUsualHeight));
    addViews(scene, cells, half, views, fovY, seed);
}

}  // namespace dapple::scenegen::city
