#include "scenegen/city/house.h"
#include "scenegen/city/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace dapple::scenegen::city;

namespace {

constexpr double kTouch = 2e-3;  // metres: corners nearer than 1 mm are one
constexpr int kSeeds = 6;

struct Town {
    Style style;
    double area;
};
class EveryPlan : public testing::TestWithParam<Town> {};

ParcelOptions parcelsOf(Style style) { return style == Style::vienna ? ParcelOptions{380, 820, 13, 0.35, 0} : ParcelOptions{420, 2600, 4 * kBay, 0.5, 2 * kBay}; }

bool segmentsCross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const auto side = [](const glm::dvec2& p, const glm::dvec2& q, const glm::dvec2& r) { return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x); };
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

/// No two edges that are not neighbours meet, by all pairs; wound counter-clockwise once.
bool isSimple(const Region& r) {
    double turn = 0;
    for (size_t i = 0; i < r.size(); ++i) {
        for (size_t j = i + 2; j < r.size(); ++j)
            if (!(i == 0 && j + 1 == r.size()) && segmentsCross(r.corners[i], r.next(i), r.corners[j], r.next(j))) return false;
        const glm::dvec2 d = r.next(i) - r.corners[i], e = r.next((i + 1) % r.size()) - r.next(i);
        turn += std::atan2(d.x * e.y - d.y * e.x, glm::dot(d, e));
    }
    return r.size() >= 3 && std::abs(turn - 2 * M_PI) < 1e-6;
}

/// Depth by which two convex polygons overlap: the least over all edge normals of both (separating axes); ≤ 0: none.
double overlap(const Region& a, const Region& b) {
    double least = 1e300;
    for (const Region* r : {&a, &b})
        for (size_t i = 0; i < r->size(); ++i) {
            const glm::dvec2 d = glm::normalize(r->next(i) - r->corners[i]), n{d.y, -d.x};
            double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
            for (int k = 0; k < 2; ++k)
                for (const glm::dvec2& p : (k ? b : a).corners) lo[k] = std::min(lo[k], glm::dot(n, p)), hi[k] = std::max(hi[k], glm::dot(n, p));
            least = std::min(least, std::min(hi[0] - lo[1], hi[1] - lo[0]));
        }
    return least;
}

/// Shoelace about the origin, independent of Region::area.
double shoelace(const Region& r) {
    double sum = 0;
    for (size_t i = 0; i < r.size(); ++i) sum += r.corners[i].x * r.next(i).y - r.next(i).x * r.corners[i].y;
    return 0.5 * sum;
}

/// The street's roadway, as a convex region. It ends in the middle of another, at any angle: its last width is left out.
Region roadway(const Street& s) {
    const glm::dvec2 u = glm::normalize(s.b - s.a), n = 0.5 * s.width * glm::dvec2(-u.y, u.x), a = s.a + s.width * u, b = s.b - s.width * u;
    return {{a - n, b - n, b + n, a + n}, {0, 0, 0, 0}};
}

}  // namespace

TEST_P(EveryPlan, blocksAreSimpleAndLieBetweenStreets) {
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
        SCOPED_TRACE(seed);
        const Plan plan = layOut(GetParam().style, GetParam().area, seed);
        ASSERT_GT(plan.blocks.size(), 0u);
        double land = 0;
        for (size_t i = 0; i < plan.blocks.size(); ++i) {
            const Block& block = plan.blocks[i];
            ASSERT_TRUE(isSimple(block.kerb));
            ASSERT_TRUE(isSimple(block.lot));
            land += shoelace(block.kerb);
            for (const glm::dvec2& p : block.lot.corners) ASSERT_TRUE(block.kerb.contains(p, 2.5)) << "the pavement";
            for (size_t j = i + 1; j < plan.blocks.size(); ++j) ASSERT_LT(overlap(block.kerb, plan.blocks[j].kerb), 0) << i << " and " << j;
            for (const Street& street : plan.streets) ASSERT_LT(overlap(block.kerb, roadway(street)), kTouch);
            for (size_t e = 0; e < block.kerb.size(); ++e) {
                // Every edge runs along its street, half a width away.
                const Street& s = plan.streets[size_t(block.kerb.labels[e])];
                const glm::dvec2 u = glm::normalize(s.b - s.a), m = 0.5 * (block.kerb.corners[e] + block.kerb.next(e)) - s.a;
                ASSERT_NEAR(std::abs(u.x * m.y - u.y * m.x), 0.5 * s.width, kTouch);
            }
        }
        EXPECT_GT(land, 0.55 * GetParam().area);
        EXPECT_LT(land, 0.95 * shoelace(plan.ground));
    }
}

TEST_P(EveryPlan, parcelsCoverTheLotAndReachAStreet) {
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
        SCOPED_TRACE(seed);
        const Plan plan = layOut(GetParam().style, GetParam().area, seed);
        const ParcelOptions options = parcelsOf(GetParam().style);
        for (size_t b = 0; b < plan.blocks.size(); ++b) {
            const Region& lot = plan.blocks[b].lot;
            const std::vector<Region> parcels = subdivide(lot, options, seed * 1000 + b);
            double sum = 0;
            for (size_t i = 0; i < parcels.size(); ++i) {
                const Region& parcel = parcels[i];
                ASSERT_TRUE(isSimple(parcel));
                sum += shoelace(parcel);
                double frontage = 0;
                for (size_t e = 0; e < parcel.size(); ++e) {
                    const glm::dvec2 m = 0.5 * (parcel.corners[e] + parcel.next(e));
                    double toStreet = 1e300;
                    for (size_t k = 0; k < lot.size(); ++k) {
                        const glm::dvec2 a = lot.corners[k], d = lot.next(k) - a;
                        const double t = std::clamp(glm::dot(m - a, d) / glm::dot(d, d), 0.0, 1.0);
                        toStreet = std::min(toStreet, glm::distance(m, a + t * d));
                    }
                    if (toStreet < kTouch) frontage += glm::distance(parcel.corners[e], parcel.next(e));
                }
                ASSERT_GE(frontage, std::min(options.widthMin, 3.0) - kTouch);
                if (parcels.size() > 1) {
                    ASSERT_GE(frontage, options.widthMin - 2 * kTouch);
                }
                for (size_t j = i + 1; j < parcels.size(); ++j) ASSERT_LT(overlap(parcel, parcels[j]), kTouch);
            }
            ASSERT_NEAR(sum, shoelace(lot), 1e-3 * shoelace(lot));
        }
    }
}

TEST_P(EveryPlan, plansRepeatAndDependOnTheSeed) {
    const auto corners = [&](uint64_t seed) {
        std::vector<glm::dvec2> all;
        const Plan plan = layOut(GetParam().style, GetParam().area, seed);
        for (const Block& block : plan.blocks)
            for (const Region& parcel : subdivide(block.lot, parcelsOf(GetParam().style), seed)) all.insert(all.end(), parcel.corners.begin(), parcel.corners.end());
        return all;
    };
    EXPECT_EQ(corners(1), corners(1));
    EXPECT_NE(corners(1), corners(2));
}

INSTANTIATE_TEST_SUITE_P(Styles, EveryPlan, testing::Values(Town{Style::vienna, 15e3}, Town{Style::vienna, 2e5}, Town{Style::vienna, 9e5}, Town{Style::manhattan, 6e4}, Town{Style::manhattan, 1e6}),
                         [](const auto& test) { return (test.param.style == Style::vienna ? "vienna" : "manhattan") + std::to_string(int(test.param.area)); });

TEST(Region, clippingSplitsTheArea) {
    const Region hexagon{{{2, 0}, {1, 2}, {-1, 2}, {-2, 0}, {-1, -2}, {1, -2}}, {0, 1, 2, 3, 4, 5}};
    for (int k = 0; k < 64; ++k) {
        const Line cut{{0.02 * k - 0.7, 0.3}, {std::cos(0.1 * k), std::sin(0.1 * k)}};
        const Region left = clip(hexagon, cut, 9), right = clip(hexagon, cut.reversed(), 9);
        EXPECT_NEAR(left.area() + right.area(), shoelace(hexagon), 5e-3) << "a corner may move by a millimetre";
        EXPECT_EQ(std::count(left.labels.begin(), left.labels.end(), 9), 1);
        for (const glm::dvec2& p : left.corners) EXPECT_GT(cut.distance(p), -1e-9);
        for (size_t i = 0; i < left.size(); ++i) {
            // A labelled edge still lies on the edge of that name.
            if (left.labels[i] == 9) continue;
            const Line e = hexagon.edge(size_t(left.labels[i]));
            EXPECT_NEAR(e.distance(left.corners[i]), 0, 2e-3);
            EXPECT_NEAR(e.distance(left.next(i)), 0, 2e-3);
        }
    }
    EXPECT_TRUE(clip(hexagon, {{3, 0}, {0, -1}}, 9).empty());
    EXPECT_EQ(clip(hexagon, {{-3, 0}, {0, -1}}, 9).size(), 6u);
}

TEST(Region, orientedBoxIsTheLeastOfAllDirections) {
    const Region r{{{0, 0}, {5, 1}, {7, 4}, {3, 6}, {-1, 3}}, {0, 0, 0, 0, 0}};
    const Extent box = orientedBox(r);
    double least = 1e300;
    for (int k = 0; k < 3600; ++k) {
        const glm::dvec2 u{std::cos(k * M_PI / 3600), std::sin(k * M_PI / 3600)}, v{-u.y, u.x};
        double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
        for (const glm::dvec2& p : r.corners) {
            lo[0] = std::min(lo[0], glm::dot(p, u)), hi[0] = std::max(hi[0], glm::dot(p, u));
            lo[1] = std::min(lo[1], glm::dot(p, v)), hi[1] = std::max(hi[1], glm::dot(p, v));
        }
        least = std::min(least, (hi[0] - lo[0]) * (hi[1] - lo[1]));
    }
    EXPECT_LE(box.length() * box.width(), least + 1e-9);
    EXPECT_GE(box.length(), box.width());
    for (int k = 0; k < 100; ++k) {
        const double a = -M_PI + 0.0628 * (k + 0.5);
        EXPECT_NEAR(angleOf({std::cos(a), std::sin(a)}), a, 1e-7);
    }
}
