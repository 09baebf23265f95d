#include "scenegen/city/footprints.h"

#include "base/error.h"
#include "base/file.h"
#include "base/random.h"
#include "scenegen/city/triangulate.h"
#include "scenegen/library.h"
#include "scenegen/lod/connectivity.h"
#include "winding.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

using namespace dapple::scenegen;
using namespace dapple::scenegen::city;
using testing::HasSubstr;

namespace {

std::string collection(const std::string& features) { return "{\"type\":\"FeatureCollection\",\"features\":[" + features + "]}"; }

std::string polygon(const std::vector<Ring>& rings, const std::string& properties) {
    std::string text;
    for (const Ring& ring : rings) {
        text += text.empty() ? "[" : ",[";
        for (size_t i = 0; i <= ring.size(); ++i) text += fmt::format("{}[{},{}]", i ? "," : "", ring[i % ring.size()].x, ring[i % ring.size()].y);
        text += "]";
    }
    return "{\"type\":\"Feature\",\"properties\":{" + properties + "},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[" + text + "]}}";
}

Ring square(double x, double y, double size) { return {{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}}; }

/// A star with `corners` teeth of random length: simple, far from convex.
Ring star(uint64_t seed, int corners, double radius) {
    dapple::base::Random random(seed, 0, 0);
    Ring ring;
    for (int k = 0; k < corners; ++k) {
        const double a = 2 * M_PI * k / corners, r = radius * (0.5 + 0.5 * random.next());
        ring.emplace_back(r * std::cos(a), r * std::sin(a));
    }
    return ring;
}

double volume(const Mesh& mesh) {
    double sum = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
        sum += glm::dot(glm::dvec3(mesh.positions[mesh.indices[i]]), glm::cross(glm::dvec3(mesh.positions[mesh.indices[i + 1]]), glm::dvec3(mesh.positions[mesh.indices[i + 2]]))) / 6;
    return sum;
}

std::string errorOf(const std::string& text, bool projected = true) {
    try {
        parseFootprints(text, "town.geojson", projected);
    } catch (const dapple::base::UsageError& e) {
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST(Footprints, prismsAreClosedAndHoldTheirVolume) {
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        Footprint f{{star(seed, 5 + int(seed % 20), 30)}, 9.0 + double(seed)};
        double area = 0.5 * twiceArea(f.rings[0]);
        if (seed % 2)
            for (const glm::dvec2 at : {glm::dvec2(-6, -2), glm::dvec2(4, -3), glm::dvec2(-1, 5)}) {
                Ring hole = star(seed + 99, 7, 2.5);
                for (glm::dvec2& p : hole) p += at;
                area -= 0.5 * twiceArea(hole);
                std::reverse(hole.begin(), hole.end());
                f.rings.push_back(hole);
            }
        const Mesh mesh = footprintPrism(f, 0.002);
        const Connectivity c = connectivity(mesh);
        EXPECT_TRUE(c.closed()) << c.boundary << " open, " << c.nonManifold << " non-manifold, " << c.degenerate << " degenerate";
        EXPECT_NEAR(volume(mesh), area * (f.height + 0.5), 0.01 * area * f.height) << "less the joint of 2 mm";
        for (double x = -29; x < 30; x += 3.7)
            for (double y = -29; y < 30; y += 3.9) {
                bool inside = contains(f.rings[0], {x, y});
                for (size_t h = 1; h < f.rings.size(); ++h) inside = inside && !contains(f.rings[h], {x, y});
                EXPECT_EQ(windingNumber(mesh, {x, y, 4.1}), int(inside));
            }
    }
}

TEST(Footprints, trianglesCoverThePolygonOnce) {
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        const Ring ring = star(seed, 40, 10);
        const auto triangles = triangulate({ring});
        EXPECT_EQ(triangles.size(), ring.size() - 2);
        double sum = 0;
        for (const auto& t : triangles) {
            const double twice = twiceArea({ring[t[0]], ring[t[1]], ring[t[2]]});
            EXPECT_GT(twice, 0);
            sum += twice;
        }
        EXPECT_NEAR(sum, twiceArea(ring), 1e-9) << "all turn the same way and add up: none overlap";
    }
}

TEST(Footprints, neighboursWithACommonWallStayClosed) {
    std::string features;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 4; ++j) features += (features.empty() ? "" : ",") + polygon({square(10 * i, 10 * j, 10)}, "\"height\": 12");
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "row.geojson", recipe = std::filesystem::path(testing::TempDir()) / "row.toml";
    dapple::base::writeFile(file, collection(features));
    dapple::base::writeFile(recipe, fmt::format("description = \"x\"\n[city]\nfootprints = \"{}\"\nprojected = true\n", file.string()));
    const Scene scene = loadScene(recipe.string());
    const Facts f = scene.facts();
    EXPECT_TRUE(f.closed);
    EXPECT_EQ(f.triangles, 20u * 12 + 12);
    EXPECT_NEAR(f.box.hi.z, 12, 1e-5);
    EXPECT_EQ(scene.views.back().name, "above");
}

TEST(Footprints, heightsAreThoseOfTheFile) {
    const Footprints f = parseFootprints(collection(polygon({square(0, 0, 5)}, "\"height\": 17.5") + "," + polygon({square(10, 0, 5)}, "\"height\": \"9.5 m\"") + "," +
                                                    polygon({square(20, 0, 5)}, "\"building:levels\": \"4\"") + "," + polygon({square(30, 0, 5)}, "\"height\": null") + "," +
                                                    polygon({square(40, 0, 5)}, "\"height\": -3, \"levels\": 2") + ",{\"type\":\"Feature\",\"geometry\":{\"type\":\"Point\",\"coordinates\":[1,2]}}"),
                                         "x", true);
    std::vector<double> heights;
    for (const Footprint& b : f.buildings) heights.push_back(b.height);
    EXPECT_EQ(heights, (std::vector<double>{17.5, 9.5, 4 * kStorey, kUsualHeight, 2 * kStorey}));
    EXPECT_EQ(f.withoutHeight, 1u);
    // The middle is the origin; both orders of corners are understood, and the closing corner is dropped.
    EXPECT_NEAR(f.buildings[0].rings[0][0].x, -22.5, 1e-9);
    EXPECT_EQ(f.buildings[0].rings[0].size(), 4u);
    Ring clockwise = square(0, 0, 5);
    std::reverse(clockwise.begin(), clockwise.end());
    EXPECT_GT(twiceArea(parseFootprints(collection(polygon({clockwise}, "")), "x", true).buildings[0].rings[0]), 0);
}

TEST(Footprints, degreesBecomeMetres) {
    // A hundredth of a degree in Vienna: 744.4 m east-west and 1,113 m north-south on a sphere of WGS 84's equator.
    const Ring ring{{16.37, 48.20}, {16.38, 48.20}, {16.38, 48.21}, {16.37, 48.21}};
    const Footprints f = parseFootprints(collection(polygon({ring}, "\"height\": 20")), "x", false);
    dapple::base::Box box;
    for (const glm::dvec2& p : f.buildings[0].rings[0]) box.extend(glm::vec3(glm::vec2(p), 0));
    EXPECT_NEAR(box.size().x, 6378137.0 * M_PI / 180 * 0.01 * std::cos(48.205 * M_PI / 180), 0.1);
    EXPECT_NEAR(box.size().y, 6378137.0 * M_PI / 180 * 0.01, 0.1);
    EXPECT_NEAR(box.centre().x, 0, 1e-3);
}

TEST(Footprints, outlinesThatCannotStandAreCounted) {
    const Ring bow{{0, 0}, {10, 10}, {10, 0}, {0, 10}}, speck = square(50, 0, 0.5);
    const Footprints f = parseFootprints(collection(polygon({bow}, "") + "," + polygon({speck}, "") + "," + polygon({square(20, 0, 5)}, "") + "," + polygon({square(20, 0, 5)}, "") + "," +
                                                    polygon({square(30, 0, 10), square(33, 3, 3), square(38, 8, 5)}, "")),
                                         "x", true);
    EXPECT_EQ(f.buildings.size(), 2u);
    EXPECT_EQ(f.refused, 3u);
    EXPECT_EQ(f.buildings[1].rings.size(), 2u) << "a courtyard that crosses the outline is dropped";
}

TEST(Footprints, badFilesNameThemselvesAndTheReason) {
    EXPECT_EQ(errorOf("{\"type\": "), "town.geojson: not valid JSON");
    EXPECT_THAT(errorOf("[1, 2]"), HasSubstr("town.geojson: not a GeoJSON FeatureCollection"));
    EXPECT_THAT(errorOf("{\"type\": 3}"), HasSubstr("not a GeoJSON FeatureCollection"));
    EXPECT_THAT(errorOf(collection("")), HasSubstr("no polygon"));
    EXPECT_THAT(errorOf(collection("3, null, {\"geometry\": null}")), HasSubstr("no polygon"));
    EXPECT_THAT(errorOf(collection("{\"geometry\":{\"type\":\"Polygon\"}}")), HasSubstr("feature 1: a polygon without coordinates"));
    EXPECT_THAT(errorOf(collection("{\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[[0,\"a\"]]]}}")), HasSubstr("feature 1: a coordinate is not a pair"));
    EXPECT_THAT(errorOf(collection("{\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[5]}}")), HasSubstr("a ring is not an array"));
    EXPECT_THAT(errorOf(collection("{\"geometry\":{\"type\":\"MultiPolygon\",\"coordinates\":[5]}}")), HasSubstr("not an array of rings"));
    EXPECT_THAT(errorOf(collection(polygon({square(1000, 0, 5)}, "")), false), HasSubstr("say projected = true"));
    EXPECT_THAT(errorOf(collection(polygon({square(0, 0, 5)}, "") + "," + polygon({square(1e8, 0, 5)}, ""))), HasSubstr("km from end to end"));
    EXPECT_THAT(errorOf(collection(polygon({square(0, 0, 0.1)}, ""))), HasSubstr("every polygon"));
    EXPECT_EQ(errorOf(collection(polygon({square(0, 0, 5)}, ""))), "no error");
}
