#include "scenegen/city/triangulate.h"

#include "base/random.h"
#include "scenegen/city/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <string>

using namespace dapple::scenegen::city;
using dapple::base::Random;

namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

Ring reversed(Ring ring) {
    std::reverse(ring.begin(), ring.end());
    return ring;
}

Ring square(double x, double y, double size) { return {{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}}; }

/// A star whose corners lie at random distances, or at two in turn.
Ring star(uint64_t seed, int corners, double inner, double outer, const glm::dvec2& at = {0, 0}) {
    Random random(seed, 0, 0);
    Ring ring;
    for (int k = 0; k < corners; ++k) {
        const double a = 2 * M_PI * k / corners;
        const double r = seed ? inner + (outer - inner) * double(random.next()) : k % 2 ? inner : outer;
        ring.push_back(at + r * glm::dvec2(std::cos(a), std::sin(a)));
    }
    return ring;
}

/// Teeth that are long and thin, of one length or of random ones.
Ring comb(uint64_t seed, int teeth, double length) {
    Random random(seed, 0, 0);
    Ring ring{{0, -1}, {2.0 * teeth, -1}};
    for (int k = teeth - 1; k >= 0; --k) {
        const double y = seed ? length * double(random.next()) + 1 : length;
        ring.insert(ring.end(), {{2.0 * k + 1.5, 0}, {2.0 * k + 1.5, y}, {2.0 * k + 0.5, y}, {2.0 * k + 0.5, 0}});
    }
    return ring;
}

/// A band wound about the middle.
Ring spiral(int corners, double turns) {
    Ring out, in;
    for (int k = 0; k < corners / 2; ++k) {
        const double a = turns * 2 * M_PI * k / (corners / 2.0), r = 1 + a;
        out.emplace_back((r + 2) * std::cos(a), (r + 2) * std::sin(a));
        in.emplace_back(r * std::cos(a), r * std::sin(a));
    }
    out.insert(out.end(), in.rbegin(), in.rend());
    return out;
}

/// Twice the area of a polygon with holes.
double twiceAreas(const std::vector<Ring>& rings) {
    double sum = 0;
    for (const Ring& ring : rings) sum += twiceArea(ring);
    return sum;
}

std::vector<glm::dvec2> cornersOf(const std::vector<Ring>& rings) {
    std::vector<glm::dvec2> out;
    for (const Ring& ring : rings) out.insert(out.end(), ring.begin(), ring.end());
    return out;
}

/// All turn left, and their areas add up to that of the polygon; so with `edges`, every ring's edge is run through once
/// and every other edge once in each direction: the triangles cover the polygon once and nothing else.
void expectExact(const std::vector<Ring>& rings, const Triangles& triangles, bool edges = true) {
    const std::vector<glm::dvec2> p = cornersOf(rings);
    double sum = 0;
    std::map<std::pair<uint32_t, uint32_t>, int> balance;
    for (const auto& t : triangles) {
        ASSERT_GT(turn(p[t[0]], p[t[1]], p[t[2]]), 0);
        sum += twiceArea({p[t[0]], p[t[1]], p[t[2]]});
        for (int k = 0; k < 3; ++k) ++balance[{t[size_t(k)], t[size_t((k + 1) % 3)]}];
    }
    EXPECT_NEAR(sum, twiceAreas(rings), 1e-9 * std::abs(twiceAreas(rings)));
    if (!edges) return;
    uint32_t first = 0;
    for (const Ring& ring : rings) {
        for (uint32_t i = 0; i < ring.size(); ++i) --balance[{first + i, first + uint32_t((i + 1) % ring.size())}];
        first += uint32_t(ring.size());
    }
    for (const auto& [edge, count] : balance) {
        const auto back = balance.find({edge.second, edge.first});
        ASSERT_EQ(count, back == balance.end() ? 0 : back->second) << edge.first << "-" << edge.second;
        ASSERT_LE(std::abs(count), 1);
    }
}

/// Seconds of processor time that the fastest of three runs takes: other work on the machine hardly counts.
double secondsOf(const std::vector<Ring>& rings, Triangles& triangles) {
    double best = 1e9;
    for (int i = 0; i < 3; ++i) {
        const std::clock_t start = std::clock();
        triangles = triangulate(rings);
        best = std::min(best, double(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return best;
}

}  // namespace

TEST(Triangulate, concaveRoofsWhicheverCornerComesFirst) {
    const std::vector<std::pair<Ring, double>> shapes = {
        {{{0, 0}, {8, 0}, {8, 4}, {4, 4}, {4, 8}, {0, 8}}, 48},                                // L
        {{{2, 0}, {4, 0}, {4, 4}, {6, 4}, {6, 8}, {0, 8}, {0, 4}, {2, 4}}, 32},                // T
        {{{0, 0}, {9, 0}, {9, 9}, {6, 9}, {6, 3}, {3, 3}, {3, 9}, {0, 9}}, 63},                // U
        {{{0, 0}, {3, 1}, {6, 0}, {5, 3}, {6, 6}, {3, 5}, {0, 6}, {1, 3}}, 24},                // dented
        {{{0, 0}, {1, 0}, {2, 0}, {2, 0}, {2, 2}, {1, 2}, {0, 2}, {0, 2}, {0, 1}, {0, 0}}, 4}, // straight, repeated
    };
    for (auto [ring, area] : shapes)
        for (size_t i = 0; i < ring.size(); ++i) {
            SCOPED_TRACE(testing::Message() << area << " m², corner " << i);
            EXPECT_EQ(twiceArea(ring), 2 * area);
            const Triangles t = triangulate({ring});
            const bool repeats = ring.front() == ring.back() ||
                                 std::adjacent_find(ring.begin(), ring.end()) != ring.end();
            expectExact({ring}, t, !repeats);
            std::rotate(ring.begin(), ring.begin() + 1, ring.end());
        }
}

TEST(Triangulate, starsWithHolesAreCoveredOnce) {
    for (uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE(seed);
        std::vector<Ring> rings{star(seed, 5 + int(seed % 60), 15, 30)};
        if (seed % 3)
            for (const glm::dvec2 at : {glm::dvec2(-6, -2), glm::dvec2(4, -3), glm::dvec2(-1, 5)})
                rings.push_back(reversed(star(seed + 999, 3 + int(seed % 9), 1.2, 2.5, at)));
        const Triangles triangles = triangulate(rings);
        EXPECT_EQ(triangles.size(), cornersOf(rings).size() - 2 + 2 * (rings.size() - 1));
        expectExact(rings, triangles);
    }
}

/// On a coarse grid most corners repeat, lie in line with others, touch edges and other rings.
TEST(Triangulate, coversWhatAnOddNumberOfRingsEncloses) {
    size_t covered = 0, crossing = 0;
    for (uint64_t seed = 1; seed <= 4000; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed, 0, 0);
        std::vector<Ring> rings(1 + seed % 3);
        for (Ring& ring : rings)
            for (int n = 3 + int(random.next() * 6); n > 0; --n)
                ring.emplace_back(std::floor(random.next() * 5), std::floor(random.next() * 5));
        const Triangles triangles = triangulate(rings);
        const std::vector<glm::dvec2> p = cornersOf(rings);
        // Brute force: whether two edges cross where no corner is.
        bool crosses = false;
        std::vector<std::pair<glm::dvec2, glm::dvec2>> edges;
        for (const Ring& ring : rings)
            for (size_t i = 0; i < ring.size(); ++i)
                edges.emplace_back(ring[i], ring[(i + 1) % ring.size()]);
        for (const auto& [a, b] : edges)
            for (const auto& [c, d] : edges) {
                bool here = turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
                for (const glm::dvec2& q : p) here = here && (turn(a, b, q) != 0 || turn(c, d, q) != 0);
                crosses = crosses || here;
            }
        crossing += crosses;
        if (crosses) {
            EXPECT_TRUE(triangles.empty());
            continue;
        }
        // Even-odd against triangles, at points off the grid's lines.
        double area = 0;
        for (const auto& t : triangles) {
            ASSERT_GT(turn(p[t[0]], p[t[1]], p[t[2]]), 0);
            area += 0.5 * twiceArea({p[t[0]], p[t[1]], p[t[2]]});
        }
        covered += area > 0;
        for (double x = -0.2713; x < 5; x += 0.31)
            for (double y = -0.23; y < 5; y += 0.29) {
                bool inside = false;
                for (const Ring& ring : rings) inside = inside != contains(ring, {x, y});
                int times = 0;
                for (const auto& t : triangles) times += contains({p[t[0]], p[t[1]], p[t[2]]}, {x, y});
                ASSERT_EQ(times, int(inside)) << x << ", " << y;
            }
    }
    EXPECT_GT(covered, 300u);
    EXPECT_GT(crossing, 300u);
}

TEST(Triangulate, holesThatTouch) {
    const Ring outline = square(0, 0, 30);
    // At a corner of the outline, in the middle of an edge, and two holes at one point.
    const std::vector<std::vector<Ring>> cases = {{reversed({{0, 0}, {10, 4}, {4, 10}})},
                                                  {reversed({{15, 0}, {20, 10}, {10, 10}})},
                                                  {reversed(square(5, 5, 10)), reversed(square(15, 15, 10))},
                                                  {reversed(square(0, 0, 10))}};
    for (const std::vector<Ring>& holes : cases) {
        std::vector<Ring> rings{outline};
        rings.insert(rings.end(), holes.begin(), holes.end());
        expectExact(rings, triangulate(rings), false);
    }
}

TEST(Triangulate, bridgesKeepTheirTwoSidesApart) {
    // A square hole in a square, tied to the outline by an edge there and back: corners 0, 5 and 4, 9 lie at one place.
    const Ring keyhole{{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 6}, {6, 3}, {3, 3}};
    EXPECT_EQ(twiceArea(keyhole), 2 * 72);
    const Triangles triangles = triangulate({keyhole});
    EXPECT_EQ(triangles.size(), 8u);
    expectExact({keyhole}, triangles);
    // Rounded to floats far from the origin, the two sides of a slanted bridge cross by rounding.
    for (uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed, 0, 0);
        Ring ring = keyhole;
        const double a = random.next() * 7;
        for (glm::dvec2& p : ring) {
            const glm::dvec2 turned(std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y);
            p = glm::dvec2(glm::vec2(turned + 100.0));
        }
        ring.insert(ring.begin() + 5, glm::dvec2(glm::vec2(glm::mix(ring[4], ring[5], 0.3))));
        const Triangles t = triangulate({ring});
        double area = 0;
        for (const auto& [i, j, k] : t) area += 0.5 * twiceArea({ring[i], ring[j], ring[k]});
        EXPECT_NEAR(area, 72, 1e-3);
    }
}

TEST(Triangulate, ringsThatCrossOrEncloseNothingGiveNothing) {
    EXPECT_TRUE(triangulate({{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}).empty()) << "bow";
    EXPECT_TRUE(triangulate({square(0, 0, 10), reversed(square(8, 8, 5))}).empty());
    EXPECT_TRUE(triangulate({{{0, 0}, {1, 1}, {2, 2}, {3, 3}}}).empty()) << "a line";
    EXPECT_TRUE(triangulate({{{0, 0}, {1, 1}}}).empty());
    EXPECT_TRUE(triangulate({{{5, 5}, {5, 5}, {5, 5}}}).empty());
    EXPECT_TRUE(triangulate({{{0, 0}, {1, 0}, {NAN, 1}}}).empty());
    EXPECT_TRUE(triangulate({{{0, 0}, {1e300, 0}, {0, 1e300}}}).empty());
    EXPECT_TRUE(triangulate({}).empty());
}

TEST(Triangulate, turnsAreExact) {
    // Points next to the line y = x: rounded arithmetic calls some left that lie right.
    for (int i = 0; i < 256; ++i)
        for (int j = 0; j < 256; ++j) {
            const glm::dvec2 p(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53);
            const double t = turn({12, 12}, {24, 24}, p);
            ASSERT_EQ(t > 0, j > i) << i << " " << j;
            ASSERT_EQ(t < 0, j < i) << i << " " << j;
        }
}

TEST(Triangulate, tensOfThousandsOfCornersTakeLessThanASecond) {
    std::vector<Ring> pierced{star(0, 8000, 60, 100)};
    for (int x = -5; x < 5; ++x)
        for (int y = -5; y < 5; ++y) pierced.push_back(reversed(star(0, 40, 1, 3, {7 * x + 3.5, 7 * y + 3.5})));
    Ring slanted = comb(9, 12'000, 1e6);
    for (glm::dvec2& p : slanted) p = {0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y};
    const std::vector<std::pair<std::string, std::vector<Ring>>> cases = {
        {"slanted comb", {slanted}},
        {"circle", {star(0, 50'000, 100, 100)}},
        {"star", {star(0, 50'000, 50, 100)}},
        {"random star", {star(3, 50'000, 10, 100)}},
        {"comb", {comb(0, 12'000, 5000)}},
        {"random comb", {comb(5, 12'000, 5000)}},
        {"long comb", {comb(7, 12'000, 1e6)}},
        {"spiral", {spiral(50'000, 100)}},
        {"tight spiral", {spiral(50'000, 200)}},
        {"star with holes", pierced},
    };
    for (const auto& [name, rings] : cases) {
        SCOPED_TRACE(name);
        Triangles triangles;
        const double seconds = secondsOf(rings, triangles);
        std::printf("%s: %zu corners, %.3f s\n", name.c_str(), cornersOf(rings).size(), seconds);
        EXPECT_LT(seconds, 1);
        expectExact(rings, triangles);
    }
}
