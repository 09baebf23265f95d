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
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

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

/// The highest point of each building of a scene: what hangs together at equal positions is one.
std::vector<double> builtHeights(const Scene& scene) {
    std::vector<double> heights;
    for (const Instance& instance : scene.instances) {
        const Prototype& prototype = scene.prototypes[instance.prototype];
        if (!prototype.castsShadow) continue;  // the ground
        for (const Mesh& mesh : prototype.meshes) {
            std::map<std::array<float, 3>, size_t> number;
            std::vector<size_t> parent;
            const auto root = [&](size_t i) {
                while (parent[i] != i) i = parent[i] = parent[parent[i]];
                return i;
            };
            std::vector<size_t> of;
            for (const glm::vec3& p : mesh.positions) {
                const auto [at, isNew] = number.try_emplace({p.x, p.y, p.z}, parent.size());
                if (isNew) parent.push_back(parent.size());
                of.push_back(at->second);
            }
            for (size_t i = 0; i < mesh.indices.size(); ++i) parent[root(of[mesh.indices[i]])] = root(of[mesh.indices[i % 3 ? i - 1 : i]]);
            std::map<size_t, float> top;
            for (size_t i = 0; i < of.size(); ++i) {
                float& z = top.try_emplace(root(of[i]), -1e9f).first->second;
                z = std::max(z, mesh.positions[i].z);
            }
            for (const auto& [building, z] : top) heights.push_back(double(z + instance.translation.z));
        }
    }
    return heights;
}

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.at(size_t(share * double(values.size() - 1)));
}

TEST(Footprints, theBuiltSceneHasTheHeightsOfTheFile) {
    // Skewed as a city's are: log-normal about 8 m, a third of the buildings given by their levels.
    dapple::base::Random random(7, 0, 0);
    std::vector<double> given;
    std::string features;
    for (int i = 0; i < 900; ++i) {
        double normal = -6;
        for (int k = 0; k < 12; ++k) normal += double(random.next());
        const double height = 8 * std::exp(0.7 * normal);
        const bool levels = i % 3 == 0;
        const int storeys = std::max(1, int(height / 3.2 + 0.5));
        given.push_back(levels ? 3.2 * storeys : height);
        features += (i ? "," : "") + polygon({square(25 * (i % 30), 25 * (i / 30), 8 + 10 * double(random.next()))}, levels ? fmt::format("\"building:levels\": \"{}\"", storeys) : fmt::format("\"height\": {}", height));
    }
    const std::filesystem::path folder = testing::TempDir();
    dapple::base::writeFile(folder / "skewed.geojson", collection(features));
    dapple::base::writeFile(folder / "skewed.toml", "description = \"x\"\n[city]\nfootprints = \"skewed.geojson\"\nprojected = true\n");
    const std::vector<double> built = builtHeights(loadScene((folder / "skewed.toml").string()));
    EXPECT_EQ(built.size(), given.size());
    EXPECT_GT(quantile(given, 0.95), 2 * quantile(given, 0.5)) << "skewed";
    for (const double share : {0.05, 0.5, 0.95}) EXPECT_NEAR(quantile(built, share), quantile(given, share), 0.01 * quantile(given, share)) << share;
}

/// Of the buildings of which the file says a height; the file is read here once more, by other code.
TEST(Footprints, astanaHasTheHeightsOfItsFile) {
    const std::filesystem::path file = dapple::base::cacheFolder() / "real/astana/buildings.geojson";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "not fetched; run scenegen/import/fetch_astana";
    nlohmann::json json = nlohmann::json::parse(dapple::base::readFile(file)), kept = nlohmann::json::array();
    std::vector<double> given;
    for (const nlohmann::json& feature : json["features"]) {
        double height = 0;
        for (const char* key : {"height", "building:levels"})
            if (height == 0 && feature["properties"].contains(key)) height = std::atof(feature["properties"][key].get<std::string>().c_str()) * (*key == 'h' ? 1 : 3.2);
        if (height <= 0 || height >= 2000) continue;
        given.push_back(height);
        kept.push_back(feature);
    }
    json["features"] = kept;
    const std::filesystem::path folder = testing::TempDir();
    dapple::base::writeFile(folder / "astana_heights.geojson", json.dump());
    dapple::base::writeFile(folder / "astana_heights.toml", "description = \"x\"\n[city]\nfootprints = \"astana_heights.geojson\"\n");
    const std::vector<double> built = builtHeights(loadScene((folder / "astana_heights.toml").string()));
    EXPECT_NEAR(double(built.size()), double(given.size()), 0.02 * double(given.size()));
    for (const double share : {0.5, 0.95}) {
        fmt::print("share {}: {} buildings of the file {:.2f} m, {} built {:.2f} m\n", share, given.size(), quantile(given, share), built.size(), quantile(built, share));
        EXPECT_NEAR(quantile(built, share), quantile(given, share), 0.1 * quantile(given, share));
    }
}

TEST(Footprints, filesCountFromTheRecipesFolderAndInSettingsFromTheWorkingFolder) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "town";
    std::filesystem::create_directories(folder);
    dapple::base::writeFile(folder / "one.geojson", collection(polygon({square(0, 0, 9)}, "\"height\": 12")));
    dapple::base::writeFile(folder / "town.toml", "description = \"x\"\n[city]\nfootprints = \"one.geojson\"\nprojected = true\n");
    EXPECT_EQ(loadScene((folder / "town.toml").string()).facts().triangles, 24u);
    const auto error = [&](const std::string& setting) -> std::string {
        try {
            loadScene((folder / "town.toml").string(), {setting});
        } catch (const dapple::base::UsageError& e) {
            return e.what();
        }
        return "no error";
    };
    EXPECT_THAT(error("city.footprints=one.geojson"), HasSubstr("cannot read one.geojson:"));
    EXPECT_EQ(error("city.footprints=" + std::filesystem::relative(folder / "one.geojson").string()), "no error");
    std::filesystem::remove(folder / "one.geojson");
    EXPECT_THAT(error("seed=2"), HasSubstr("cannot read " + (folder / "one.geojson").string() + ":"));
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
