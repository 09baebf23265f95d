#include "base/error.h"
#include "base/file.h"
#include "scenegen/library.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/plants/bark.h"
#include "scenegen/plants/colonise.h"
#include "scenegen/plants/tree.h"
#include "manifold.h"
#include "winding.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <filesystem>
#include <future>

using namespace dapple::scenegen;

namespace {

TreeOptions level(const Species& species, uint64_t seed, int lod, LeafMode leaves = LeafMode::polygon) {
    return {seed, species.triangles[size_t(lod)], leaves, lod, {}};
}

double volume(const Mesh& m) {
    double sum = 0;
    for (size_t i = 0; i < m.indices.size(); i += 3)
        sum += glm::dot(glm::dvec3(m.positions[m.indices[i]]), glm::cross(glm::dvec3(m.positions[m.indices[i + 1]]), glm::dvec3(m.positions[m.indices[i + 2]]))) / 6;
    return sum;
}

dapple::base::Box boxOf(const Tree& tree) { return Prototype{"", {tree.bark, tree.leaves}}.box(); }

class EverySpecies : public testing::TestWithParam<std::string> {
protected:
    Species species = loadSpecies(GetParam());
};

double declination(const glm::dvec3& d) { return std::acos(d.z / glm::length(d)) * 180 / M_PI; }

}  // namespace

TEST_P(EverySpecies, hundredIndividualsAreSoundAtEveryLevel) {
    const auto wrongWith = [&](uint64_t seed, int lod) -> std::string {
        const Tree tree = growTree(species, level(species, seed, lod));
        const size_t total = tree.bark.triangles() + tree.leaves.triangles(), budget = species.triangles[size_t(lod)];
        if (total > budget) return "more triangles than the budget";
        if (total + leafTriangles(leafShape(species, lod), LeafMode::polygon) <= budget) return "room for a leaf more";
        if (tree.leaves.triangles() <= budget / 5) return "hardly a leaf";
        if (const std::string wrong = brokenSpheres(tree.bark) + brokenTriangles(tree.bark) + brokenTriangles(tree.leaves); !wrong.empty()) return wrong;
        const size_t corners = leafVertices(leafShape(species, lod), LeafMode::polygon), leaves = tree.leaves.positions.size() / corners;
        for (size_t i = 0; lod == 0 && i < leaves; i += leaves / 4 + 1)
            if (windingNumber(tree.bark, tree.leaves.positions[corners * i]) < 1) return "a leaf floats";
        return "";
    };
    const auto half = [&](uint64_t first) {
        for (int lod = 0; lod < kLods; ++lod)
            for (uint64_t seed = first; seed <= 100; seed += 2)
                if (const std::string wrong = wrongWith(seed, lod); !wrong.empty()) return fmt::format("level {}, seed {}: {}", lod, seed, wrong);
        return std::string();
    };
    std::future<std::string> odd = std::async(std::launch::async, half, 1);
    EXPECT_EQ(half(2), "");
    EXPECT_EQ(odd.get(), "");
}

TEST_P(EverySpecies, solidLeavesAreClosedWherePolygonsAre) {
    for (int lod = 0; lod < kLods; ++lod)
        for (uint64_t seed = 1; seed <= (lod == 0 ? 3 : 10); ++seed) {
            SCOPED_TRACE(testing::Message() << "level " << lod << ", seed " << seed);
            const Tree flat = growTree(species, level(species, seed, lod)), solid = growTree(species, level(species, seed, lod, LeafMode::solid));
            ASSERT_EQ(solid.bark.positions, flat.bark.positions);
            const LeafShape shape = leafShape(species, lod);
            const size_t leaves = flat.leaves.triangles() / leafTriangles(shape, LeafMode::polygon), corners = leafVertices(shape, LeafMode::polygon);
            ASSERT_EQ(solid.leaves.triangles(), leaves * leafTriangles(shape, LeafMode::solid));
            for (size_t i = 0; i < leaves; ++i)
                for (size_t k = 0; k < corners; ++k)
                    ASSERT_EQ(solid.leaves.positions[(2 * corners + 2) * i + k], flat.leaves.positions[corners * i + k]);
            const Connectivity c = connectivity(solid.leaves);
            ASSERT_TRUE(c.closed() && c.spheres) << c.boundary << " open, " << c.nonManifold << " non-manifold";
            ASSERT_EQ(c.components, leaves);
            ASSERT_EQ(brokenTriangles(solid.leaves), "");
            ASSERT_GT(volume(solid.leaves), 0) << "outwards";
        }
}

TEST_P(EverySpecies, leavesGrowOutOfWoodNearBy) {
    for (const LeafMode mode : {LeafMode::polygon, LeafMode::card}) {
        const Tree tree = growTree(species, level(species, 3, 0, mode));
        const size_t corners = leafVertices(species.leaves.shape, mode);
        size_t floating = 0;
        for (size_t v = 0; v < tree.leaves.positions.size(); v += corners * 67) {
            glm::dvec3 root = tree.leaves.positions[v];
            if (mode == LeafMode::card) root = 0.5 * (root + glm::dvec3(tree.leaves.positions[v + 1]));
            floating += windingNumber(tree.bark, root) < 1;
        }
        EXPECT_EQ(floating, 0u);
    }
}

TEST_P(EverySpecies, coarserLevelsKeepTheOutline) {
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        const dapple::base::Box fine = boxOf(growTree(species, level(species, seed, 0)));
        for (int lod = 1; lod < kLods; ++lod) {
            SCOPED_TRACE(testing::Message() << "level " << lod << ", seed " << seed);
            const dapple::base::Box coarse = boxOf(growTree(species, level(species, seed, lod)));
            // A leaf of a coarse level stands for several, and a fern's are long against its height.
            EXPECT_NEAR(coarse.hi.z / fine.hi.z, 1, lod == 1 ? 0.25 : 0.4);
            const glm::vec3 a = fine.halfSize(), b = coarse.halfSize();
            EXPECT_NEAR((b.x + b.y) / (a.x + a.y), 1, 0.35);
        }
    }
}

TEST_P(EverySpecies, bendsInTheWindWithoutStretching) {
    const Skeleton still = growSkeleton(species, 2);
    Skeleton windy = still, later = still;
    sway(windy, {1, {0, 1}, 0}, 2);
    sway(later, {1, {0, 1}, 0.4}, 2);
    glm::dvec3 moved(0);
    for (size_t i = 0; i < still.stems.size(); ++i) {
        const std::vector<Ring>&a = still.stems[i].rings, &b = windy.stems[i].rings;
        for (size_t r = 0; r + 1 < a.size(); ++r)
            ASSERT_NEAR(glm::distance(a[r].centre, a[r + 1].centre), glm::distance(b[r].centre, b[r + 1].centre), 1e-9);
        moved += b.back().centre - a.back().centre;
    }
    EXPECT_GT(moved.y, 0) << "with the wind";
    EXPECT_LT(std::abs(moved.x), moved.y);
    EXPECT_EQ(windy.stems[0].rings[0].centre, still.stems[0].rings[0].centre) << "rooted";
    EXPECT_NE(windy.stems[0].rings.back().centre, later.stems[0].rings.back().centre);

    TreeOptions options = level(species, 2, 0);
    options.wind = Wind{1, {0, 1}, 0};
    const Tree tree = growTree(species, options), calm = growTree(species, level(species, 2, 0));
    EXPECT_EQ(tree.bark.indices, calm.bark.indices);
    EXPECT_EQ(tree.leaves.indices, calm.leaves.indices);
    EXPECT_EQ(brokenSpheres(tree.bark), "");
}

INSTANTIATE_TEST_SUITE_P(Registry, EverySpecies, testing::ValuesIn(listSpecies()), [](const auto& test) {
    std::string name = test.param;
    std::erase(name, '-');
    return name;
});

TEST(Prune, envelopeIsThatOfThePaper) {
    const PruneParameters p{1, 0.4, 0.6, 1, 1};
    EXPECT_EQ(envelopeRatio(p, 0), 0) << "top";
    EXPECT_DOUBLE_EQ(envelopeRatio(p, 0.2), 0.5);
    EXPECT_DOUBLE_EQ(envelopeRatio(p, 0.4), 1) << "peak";
    EXPECT_DOUBLE_EQ(envelopeRatio(p, 0.7), 0.5);
    EXPECT_EQ(envelopeRatio(p, 1), 0) << "foot of the crown";
    EXPECT_EQ(envelopeRatio(p, 1.1), 0);
    EXPECT_EQ(envelopeRatio(p, -0.1), 0);
}

TEST(Prune, nothingReachesBeyondTheEnvelope) {
    Species willow = loadSpecies("willow");
    willow.scaleV = 0;
    const auto outside = [&](const Skeleton& skeleton) {
        size_t count = 0;
        for (const Stem& stem : skeleton.stems)
            for (const Ring& ring : stem.rings) {
                const double height = ring.centre.z / willow.scale;  // the crown is 0.05 … 1, widest at 0.6 of that
                const double limit = height < 0.05 || height > 1 ? 0 : height > 0.62 ? 0.4 * std::sqrt((1 - height) / 0.38) : 0.4 * std::pow((height - 0.05) / 0.57, 0.001);
                count += stem.level > 0 && std::hypot(ring.centre.x, ring.centre.y) > limit * willow.scale + 1e-9;
            }
        return count;
    };
    for (uint64_t seed = 1; seed <= 10; ++seed) {
        EXPECT_EQ(outside(growSkeleton(willow, seed)), 0u);
        Species wild = willow;
        wild.prune.ratio = 0;
        EXPECT_GT(outside(growSkeleton(wild, seed)), 100u);
    }
}

TEST(Colonisation, fillsTheCrownByThePipeModel) {
    const Species oak = loadSpecies("open-oak");
    const double height = 11, radius = 0.35;
    const auto envelope = [&](double z) { return oak.prune.width * height * envelopeRatio(oak.prune, (height - z) / (height * (1 - oak.baseSize))); };
    for (uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        const std::vector<CrownNode> nodes = colonise(oak, height, radius, seed);
        ASSERT_GT(nodes.size(), 200u);
        EXPECT_EQ(nodes[0].parent, -1);
        EXPECT_DOUBLE_EQ(nodes[0].radius, radius);
        std::vector<double> area(nodes.size(), 0);
        for (size_t i = 1; i < nodes.size(); ++i) {
            ASSERT_LT(nodes[i].parent, int(i));
            ASSERT_NEAR(glm::distance(nodes[i].position, nodes[size_t(nodes[i].parent)].position), oak.colonisation->step, 1e-9);
            area[size_t(nodes[i].parent)] += std::pow(nodes[i].radius, oak.colonisation->pipe);
        }
        for (size_t i = 0; i < nodes.size(); ++i)
            if (area[i] > 0) {
                ASSERT_NEAR(std::pow(nodes[i].radius, oak.colonisation->pipe) / area[i], 1, 1e-6);
            }
        // Every place in the crown has wood nearer than an attractor's reach.
        for (double z = 2.5; z < 10.5; z += 1)
            for (double x = -7; x <= 7; x += 1)
                for (double y = -7; y <= 7; y += 1) {
                    if (std::hypot(x, y) > envelope(z)) continue;
                    double nearest = 1e9;
                    for (const CrownNode& n : nodes) nearest = std::min(nearest, glm::distance(n.position, {x, y, z}));
                    ASSERT_LT(nearest, oak.colonisation->influence) << x << " " << y << " " << z;
                }
        for (const CrownNode& n : nodes)
            if (n.position.z > oak.baseSize * height + 1 && n.position.z < height) {
                ASSERT_LT(std::hypot(n.position.x, n.position.y), envelope(n.position.z) + 1.5);
            }
    }
}

TEST(Species, willowsWeepAndAspensRise) {
    const auto meanTwigRise = [](const char* name) {
        double sum = 0, count = 0;
        for (const Stem& s : growSkeleton(loadSpecies(name), 1).stems)
            if (s.level == 2) sum += (s.rings.back().centre.z - s.rings.front().centre.z) / glm::distance(s.rings.back().centre, s.rings.front().centre), ++count;
        return sum / count;
    };
    EXPECT_LT(meanTwigRise("willow"), -0.7);
    EXPECT_LT(meanTwigRise("birch"), -0.2);
    EXPECT_GT(meanTwigRise("aspen"), 0);
}

TEST(Species, trunkRadiusScalesByItself) {
    const Species thin = loadSpecies("aspen");
    Species thick = thin;
    thick.radiusScale = 1.5;
    const Skeleton a = growSkeleton(thin, 3), b = growSkeleton(thick, 3);
    EXPECT_DOUBLE_EQ(b.stems[0].radius, 1.5 * a.stems[0].radius);
    EXPECT_EQ(b.stems[0].rings.back().centre, a.stems[0].rings.back().centre);
    EXPECT_GT(b.stems[1].radius, 1.4 * a.stems[1].radius) << "limbs go by the trunk";
    thick.radiusScaleV = 0.5;
    double lo = 1e9, hi = 0;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        const double scale = growSkeleton(thick, seed).stems[0].radius / growSkeleton(thin, seed).stems[0].radius;
        lo = std::min(lo, scale), hi = std::max(hi, scale);
    }
    EXPECT_GE(lo, 1);
    EXPECT_LT(lo, 1.1);
    EXPECT_LE(hi, 2);
    EXPECT_GT(hi, 1.9);
}

TEST(Species, zScaleStretchesTheHeightAlone) {
    for (const char* name : {"birch", "open-oak"}) {
        Species s = loadSpecies(name);
        const Skeleton a = growSkeleton(s, 2);
        s.zScale = 1.3;
        const Skeleton b = growSkeleton(s, 2);
        ASSERT_EQ(a.stems.size(), b.stems.size());
        for (size_t i = 0; i < a.stems.size(); ++i)
            for (size_t r = 0; r < a.stems[i].rings.size(); ++r) {
                const glm::dvec3 p = a.stems[i].rings[r].centre, q = b.stems[i].rings[r].centre;
                ASSERT_EQ(q, glm::dvec3(p.x, p.y, 1.3 * p.z));
            }
    }
}

TEST(Species, shapeEightIsTheEnvelope) {
    Species s = loadSpecies("aspen");
    s.shape = 8;
    s.levels[1].lengthV = 0;
    s.prune = {0, 0.4, 0.5, 1, 1};  // a double cone
    for (const Stem& stem : growSkeleton(s, 1).stems) {
        if (stem.level != 1) continue;
        const double trunk = growSkeleton(s, 1).stems[0].length, fromTop = (trunk - stem.parentOffset) / (trunk * (1 - s.baseSize));
        EXPECT_NEAR(stem.length, trunk * s.levels[1].length * (1 - std::abs(2 * fromTop - 1)), 1e-9 * trunk);
    }
}

TEST(Species, badValuesNameFileLineAndKey) {
    const std::string good = dapple::base::readFile(dapple::base::homeFolder() / "scenegen/plants/species/maple.toml");
    const auto errorWith = [&](const std::string& from, const std::string& to) -> std::string {
        std::string text = good;
        text.replace(text.find(from), from.size(), to);
        dapple::base::ConfigTable table = dapple::base::ConfigTable::parseText(text, "maple.toml");
        try {
            readSpecies(table);
        } catch (const dapple::base::UsageError& error) {
            return error.what();
        }
        return "no error";
    };
    const auto expect = [&](const std::string& from, const std::string& to, const std::string& part) {
        EXPECT_NE(errorWith(from, to).find(part), std::string::npos) << to << ": " << errorWith(from, to);
    };
    EXPECT_EQ(errorWith("maple5", "maple5"), "no error");
    expect("\"maple5\"", "\"maple7\"", "shape: 'maple7' is none of diamond, oval");
    expect("shape = 1", "shape = 9", ":5: shape: 9 is outside");
    expect("scaleV = 1.5", "scaleV = 1.5\nzScale = 0.5\nzScaleV = 0.5", ":10: zScaleV: must be below zScale");
    expect("scaleV = 1.5", "scaleV = 1.5\nradiusScale = nan", ":9: radiusScale: must be finite");
    expect("scaleV = 1.5", "scaleV = 1.5\nradiusScaleV = 2", ":9: radiusScaleV: must be below radiusScale");
}

TEST(Leaves, negativeCountMakesAFan) {
    Species s = loadSpecies("shrub");
    s.leaves.count = -9;
    s.leaves.downAngleV = s.leaves.rotateV = 0;
    s.leaves.downAngle = 60;
    Skeleton skeleton = growSkeleton(s, 1);
    const BarkPlan plan = planBark(s, skeleton, 0);
    const std::vector<LeafSite> all = leafSites(s, skeleton, plan.kept, LeafMode::polygon, false);
    const LeafSite site = all[all.size() / 2];
    const Mesh fan = buildLeaves(s, {{site}}, LeafMode::polygon, 9, 0, 1);
    const Stem& twig = *site.stem;
    std::vector<double> angles;
    for (size_t i = 0; i < 9; ++i) {
        const glm::dvec3 root = fan.positions[4 * i], d = glm::normalize(glm::dvec3(fan.positions[4 * i + 2]) - root);
        EXPECT_LT(glm::distance(root, twig.at(twig.length).centre), 0.15 * twig.length) << "at the end";
        const glm::dmat3& frame = twig.rings.back().frame;
        angles.push_back(std::atan2(glm::dot(d, frame[1]), glm::dot(d, frame[2])) * 180 / M_PI);
        EXPECT_NEAR(glm::dot(d, frame[0]), 0, 0.12) << "in one plane";
    }
    EXPECT_TRUE(std::is_sorted(angles.begin(), angles.end()) || std::is_sorted(angles.rbegin(), angles.rend()));
    EXPECT_NEAR(std::abs(angles.front() - angles.back()), 2 * 60 * 8 / 9.0 * (1.15 - 0.3), 25);
}

TEST(Leaves, everyOutlineIsSoundFlatAndSolid) {
    const Blade blade{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0.2, 0.15};
    const auto area = [](const Mesh& m, size_t i) {  // seen from above
        const glm::dvec3 a = m.positions[m.indices[i]], b = m.positions[m.indices[i + 1]], c = m.positions[m.indices[i + 2]];
        return 0.5 * glm::cross(b - a, c - a).z;
    };
    for (size_t k = 0; k < kLeafShapes.size(); ++k) {
        SCOPED_TRACE(kLeafShapes[k]);
        const auto shape = LeafShape(k);
        const auto build = [&](LeafMode mode) {
            Mesh m;
            m.positions.resize(2 * leafVertices(shape, mode));
            m.normals.resize(m.positions.size());
            m.indices.resize(6 * leafTriangles(shape, mode));
            setLeaf(m, shape, mode, 0, 0, 0, blade);
            Blade other = blade;
            other.root.z = 3;
            setLeaf(m, shape, mode, leafVertices(shape, mode), 3 * leafTriangles(shape, mode), 0, other);
            return m;
        };
        const Mesh flat = build(LeafMode::polygon), solid = build(LeafMode::solid);
        EXPECT_EQ(brokenTriangles(flat) + brokenTriangles(solid), "");
        EXPECT_EQ(glm::dvec3(flat.positions[0]), blade.root);
        double up = 0, lo = 0, hi = 0, left = 0, right = 0;
        for (size_t i = 0; i < flat.indices.size() / 2; i += 3) {
            EXPECT_GT(area(flat, i), 0) << "faces up";
            up += area(flat, i);
        }
        for (const glm::vec3& p : flat.positions) lo = std::min(lo, double(p.y)), hi = std::max(hi, double(p.y)), left = std::min(left, double(p.x)), right = std::max(right, double(p.x));
        EXPECT_NEAR(lo, 0, 1e-7);
        EXPECT_NEAR(hi, blade.length, 1e-7);
        EXPECT_NEAR(right - left, blade.width, 1e-7);
        const Connectivity c = connectivity(solid);
        EXPECT_TRUE(c.closed() && c.spheres);
        EXPECT_EQ(c.components, shape == LeafShape::three ? 6u : 2u);
        size_t upper = 0;
        double top = 0;
        for (size_t i = 0; i < solid.indices.size() / 2; i += 3)
            if (area(solid, i) > 0) top += area(solid, i), ++upper;
        EXPECT_EQ(2 * upper, leafTriangles(shape, LeafMode::solid)) << "no triangle folds over another";
        EXPECT_NEAR(top, up, 1e-6 * up) << "the same outline";
        EXPECT_GT(volume(solid), 0);
    }
}

TEST(Species, negativeCurveVMakesAHelix) {
    Species s = loadSpecies("aspen");
    s.levels[1].curveV = -30;
    s.levels[1].curveRes = 4;
    size_t tested = 0;
    for (const Stem& stem : growSkeleton(s, 1).stems) {
        if (stem.level != 1) continue;
        // Four segments are one turn, so their sum is the axis, and each declines by 30° from it.
        const glm::dvec3 axis = glm::normalize(stem.rings[4].centre - stem.rings[0].centre);
        for (size_t r = 0; r < 4; ++r) {
            const glm::dvec3 d = glm::normalize(stem.rings[r + 1].centre - stem.rings[r].centre);
            EXPECT_NEAR(glm::dot(axis, d), std::cos(M_PI / 6), 1e-9);
        }
        EXPECT_GT(declination(glm::cross(stem.rings[1].centre - stem.rings[0].centre, stem.rings[2].centre - stem.rings[1].centre)), 0);
        ++tested;
    }
    EXPECT_EQ(tested, 50u);
}

namespace {

Scene load(const std::string& text, const std::vector<std::string>& settings = {}) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "species_under_test.toml";
    dapple::base::writeFile(path, text);
    return loadScene(path.string(), settings);
}

const std::string kGrove = R"(description = "x"
trees = 12
[wind]
strength = 0
direction = 270
[ground]
size = 80
[[species]]
name = "fir"
individuals = 3
lod = 1
[path]
views = 1
)";

}  // namespace

TEST(Wind, bendsAllTreesOfASceneTheSameWay) {
    const Scene calm = load(kGrove), windy = load(kGrove, {"wind.strength=1"}), later = load(kGrove, {"wind.strength=1", "time=0.7"});
    EXPECT_FALSE(calm.facts().moving);
    EXPECT_TRUE(windy.facts().moving);
    EXPECT_EQ(windy.facts().triangles, calm.facts().triangles);
    EXPECT_NE(windy.contentHash(), later.contentHash());
    EXPECT_EQ(windy.contentHash(), load(kGrove, {"wind.strength=1"}).contentHash());
    const std::string still = std::string(kGrove).replace(kGrove.find("[wind]"), kGrove.find("[ground]") - kGrove.find("[wind]"), "");
    EXPECT_EQ(calm.contentHash(), load(still).contentHash());
    for (const Scene* scene : {&windy, &later})
        for (const Instance& instance : scene->instances) {
            const Prototype& p = scene->prototypes[instance.prototype];
            if (!p.castsShadow) continue;
            glm::vec3 top(0);
            for (const glm::vec3& v : p.meshes[0].positions)
                if (v.z > top.z) top = v;
            const float east = std::cos(instance.yaw) * top.x - std::sin(instance.yaw) * top.y;
            const float north = std::sin(instance.yaw) * top.x + std::cos(instance.yaw) * top.y;
            EXPECT_GT(east, 0.3f) << "a west wind";
            EXPECT_LT(std::abs(north), east);
        }
}

TEST(Recipe, levelsOfDetailAndPlaces) {
    const Scene scene = load(R"(description = "x"
[ground]
size = 80
[[species]]
name = "aspen"
lod = 1
leaves = "solid"
position = [3, -4]
[[species]]
name = "shrub"
lod = 2
leaves = "solid"
position = [8, 0]
[[view]]
name = "v"
eye = [0, -9, 2]
target = [0, 0, 2]
)");
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(scene.instances[1].translation.x, 3);
    EXPECT_EQ(scene.instances[1].translation.y, -4);
    EXPECT_EQ(scene.prototypes[2].meshes[0].triangles() + scene.prototypes[2].meshes[1].triangles() / 4, loadSpecies("shrub").triangles[2]);
    EXPECT_TRUE(scene.facts().closed) << "bark and solid leaves are closed casters";
}
