#include "scenegen/city/house.h"
#include "scenegen/city/plan.h"
#include "scenegen/city/tower.h"
#include "scenegen/lod/connectivity.h"
#include "winding.h"

#include "base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace dapple::scenegen;
using namespace dapple::scenegen::city;

namespace {

constexpr int kSeeds = 5;

void expectClosed(const Mesh& mesh, const char* what) {
    if (mesh.indices.empty()) return;
    const Connectivity c = connectivity(mesh);
    ASSERT_TRUE(c.closed()) << what << ": " << c.boundary << " open, " << c.nonManifold << " non-manifold, " << c.degenerate << " degenerate";
    double volume = 0;
    const glm::dvec3 o = mesh.positions[0];
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = glm::dvec3(mesh.positions[mesh.indices[i]]) - o, b = glm::dvec3(mesh.positions[mesh.indices[i + 1]]) - o, d = glm::dvec3(mesh.positions[mesh.indices[i + 2]]) - o;
        volume += glm::dot(a, glm::cross(b, d)) / 6;
        const glm::dvec3 n = glm::cross(b - a, d - a);
        ASSERT_GT(glm::dot(glm::normalize(n), glm::dvec3(mesh.normals[mesh.indices[i]])), 0.999) << what << ": normals are those of the faces";
    }
    EXPECT_GT(volume, 0) << what << " faces outwards";
}

void expectClosed(const Parts& parts) {
    expectClosed(parts.wall, "wall");
    expectClosed(parts.trim, "trim");
    expectClosed(parts.glass, "glass");
    expectClosed(parts.roof, "roof");
}

/// Distance that p lies outside a convex outline; ≤ 0 within.
double outside(const Region& r, const glm::dvec2& p) {
    double most = -1e300;
    for (size_t i = 0; i < r.size(); ++i) {
        const glm::dvec2 d = glm::normalize(r.next(i) - r.corners[i]);
        most = std::max(most, -(d.x * (p.y - r.corners[i].y) - d.y * (p.x - r.corners[i].x)));
    }
    return most;
}

struct Built {
    Region parcel;
    House house;
    Parts parts;
    std::vector<Placed> modules;
};

/// All houses of the blocks of a small town.
std::vector<std::pair<Block, std::vector<Built>>> town(uint64_t seed, bool detail) {
    std::vector<std::pair<Block, std::vector<Built>>> blocks;
    for (const Block& block : layOut(Style::vienna, 9e4, seed).blocks) {
        std::vector<Built> houses;
        const std::vector<Region> parcels = subdivide(block.lot, {380, 820, 13, 0.35, 0}, seed);
        for (size_t p = 0; p < parcels.size(); ++p) {
            Built b{parcels[p], {4 + int((p + seed) % 3), int((p / 2 + seed) % kHouseStyles), seed * 100 + p}, {}, {}};
            addHouse(b.parts, b.parcel, block.lot, b.house, detail ? &b.modules : nullptr);
            houses.push_back(std::move(b));
        }
        blocks.emplace_back(block, std::move(houses));
    }
    return blocks;
}

}  // namespace

TEST(House, everySolidIsClosedWithAndWithoutDetail) {
    for (uint64_t seed = 1; seed <= kSeeds; ++seed)
        for (const bool detail : {false, true})
            for (const auto& [block, houses] : town(seed, detail))
                for (const Built& b : houses) {
                    SCOPED_TRACE(seed);
                    expectClosed(b.parts);
                }
}

TEST(House, wallsKeepToTheirParcelAndLedgesToTheAir) {
    for (uint64_t seed = 1; seed <= kSeeds; ++seed)
        for (const auto& [block, houses] : town(seed, true))
            for (const Built& b : houses) {
                for (const glm::vec3& p : b.parts.wall.positions) ASSERT_LT(outside(b.parcel, glm::dvec2(p)), 1e-2) << "but for wings of one house that overlap by 3 mm at the corner";
                for (const Mesh* m : {&b.parts.trim, &b.parts.roof})
                    for (const glm::vec3& p : m->positions) {
                        // Cornices and eaves stand out over the pavement or the yard, never over a neighbour.
                        ASSERT_LT(outside(block.kerb, glm::dvec2(p)), -1.5);
                        if (outside(b.parcel, glm::dvec2(p)) > 1e-2) {
                            ASSERT_GT(p.z, 3.0f);
                        }
                        for (const Built& other : houses)
                            if (&other != &b) {
                                ASSERT_GT(outside(other.parcel, glm::dvec2(p)), -0.45) << "only the joint's corner may lie before a neighbour's front";
                            }
                    }
            }
}

TEST(House, noTwoHousesShareASpot) {
    // Winding numbers of all walls and roofs at points of a grid: a spot in two houses would count both.
    for (uint64_t seed = 1; seed <= kSeeds; ++seed)
        for (const auto& [block, houses] : town(seed, false)) {
            size_t inside = 0;
            for (double t = 0.05; t < 1; t += 0.1)
                for (size_t e = 0; e < block.lot.size(); ++e) {
                    const glm::dvec2 d = glm::normalize(block.lot.next(e) - block.lot.corners[e]);
                    for (const double deep : {1.0, 6.0, 11.0, 20.0}) {
                        const glm::dvec2 p = block.lot.corners[e] + t * (block.lot.next(e) - block.lot.corners[e]) + deep * glm::dvec2(-d.y, d.x);
                        int owners = 0;
                        for (const Built& b : houses) owners += windingNumber(b.parts.wall, {p, 7.3}) > 0;
                        ASSERT_LE(owners, 1);
                        inside += size_t(owners);
                    }
                }
            if (houses.size() > 4) {
                EXPECT_GT(inside, 10u);
            }
        }
}

TEST(House, adjacentWingsMeetAtOneHeight) {
    for (const auto& [block, houses] : town(2, false))
        for (const Built& b : houses)
            for (const Wing& wing : wingsOf(b.parcel, block.lot))
                for (size_t i = 0; i < wing.outline.size(); ++i)
                    for (const glm::dvec2& p : {wing.outline.corners[i], wing.outline.next(i)}) {
                        double nearest = 1e300;
                        for (size_t e = 0; e < block.lot.size(); ++e) nearest = std::min(nearest, block.lot.edge(e).distance(p));
                        EXPECT_NEAR(wing.street.distance(p), nearest, 2e-3) << "no other street is nearer, so the roofs of both wings agree there";
                        EXPECT_LT(nearest, kWingDepth + 2e-3);
                    }
}

TEST(House, modulesStandInTheirWall) {
    for (uint64_t seed = 1; seed <= 3; ++seed)
        for (const auto& [block, houses] : town(seed, true))
            for (const Built& b : houses)
                for (const Placed& m : b.modules) {
                    const glm::dvec2 inwards{-m.direction.y, m.direction.x};
                    const glm::dvec3 behind = m.what == Placed::dormer ? m.position + glm::dvec3(2.4 * inwards, -0.7) : m.position + glm::dvec3(0.27 * inwards, m.what == Placed::bay ? 5 : 0.1);
                    if (m.what != Placed::balcony) {
                        ASSERT_GE(windingNumber(b.parts.wall, behind), 1) << "what is behind a module is wall";
                    }
                    ASSERT_LT(outside(b.parcel, glm::dvec2(m.position)), 1e-3);
                }
}

TEST(House, modulesAreClosedAndAsWideAsTheirBay) {
    for (int style = 0; style < kHouseStyles; ++style)
        for (const int floors : {4, 5, 6})
            for (const BayKind kind : {BayKind::street, BayKind::shop, BayKind::door, BayKind::court}) {
                const House house{floors, style, 1};
                const Parts parts = bayModule(house, kind);
                expectClosed(parts);
                dapple::base::Box box;
                for (const glm::vec3& p : parts.wall.positions) box.extend(p);
                EXPECT_NEAR(box.size().x, house.bay() + 0.002, 1e-5);
                EXPECT_NEAR(box.hi.z, house.eaves() + 0.03, 1e-5);
                EXPECT_EQ(box.lo.y, 0) << "the wall's face is the lot's edge";
                EXPECT_GT(connectivity(parts.glass).components, size_t(floors - 1));
            }
    expectClosed(balconyModule());
    expectClosed(dormerModule());
}

TEST(Tower, everyKindIsClosedAndKeepsToItsOutline) {
    for (int style = 0; style < kTowerStyles; ++style)
        for (const int width : {4, 6, 10, 14})
            for (const int depth : {4, 8, 10})
                for (const int sides : {0, 1, 6}) {
                    const TowerKind kind{width, depth, (sides & 1) != 0, (sides & 2) != 0, (sides & 4) != 0, style, sides % 3};
                    const Parts parts = towerParts(kind, 11);
                    SCOPED_TRACE(testing::Message() << width << " × " << depth << ", style " << style);
                    expectClosed(parts);
                    const glm::dvec2 half = 0.5 * kBay * glm::dvec2(width, depth);
                    float top = 0;
                    for (const Mesh* m : {&parts.wall, &parts.glass, &parts.trim, &parts.roof})
                        for (const glm::vec3& p : m->positions) {
                            top = std::max(top, p.z);
                            const double beyond[4] = {-half.y - double(p.y), double(p.x) - half.x, double(p.y) - half.y, -half.x - double(p.x)};
                            const bool open[4] = {true, kind.right, kind.rear, kind.left};
                            for (int s = 0; s < 4; ++s) ASSERT_LT(beyond[s], m == &parts.wall || !open[s] ? 1e-4 : s == 0 ? 1.6 : 0.51) << "side " << s;
                        }
                    EXPECT_GT(top, 12);
                    expectClosed(towerParts(kind, 11, Detail::massing));
                }
}

TEST(Tower, tiersStepBack) {
    // Area of horizontal sections of the walls, counted on a grid by winding numbers, never grows with the height.
    const TowerKind kind{10, 10, true, true, true, 1, 2};
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        const Parts parts = towerParts(kind, seed, Detail::massing);
        float top = 0;
        for (const glm::vec3& p : parts.wall.positions) top = std::max(top, p.z);
        int last = 1 << 30;
        std::set<int> areas;
        for (double z = 1.03; z < top; z += 2.9) {
            int area = 0;
            for (double x = -17.5; x < 18; x += 1.13)
                for (double y = -17.4; y < 18; y += 1.17) area += windingNumber(parts.wall, {x, y, z}) > 0;
            EXPECT_LE(area, last);
            areas.insert(last = area);
        }
        EXPECT_GE(areas.size(), 2u);
    }
}
