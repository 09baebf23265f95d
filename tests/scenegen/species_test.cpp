#include "base/error.h"
#include "base/file.h"
#include "scenegen/library.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/plants/colonise.h"
#include "scenegen/plants/tree.h"
#include "winding.h"

#include <gtest/gtest.h>

#include <filesystem>

using namespace dapple::scenegen;

namespace {

void expectUnitNormals(const Mesh& mesh) {
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1.0f, 1e-5f);
}

TreeOptions level(const Species& species, uint64_t seed, int lod, LeafMode leaves = LeafMode::polygon) {
    return {seed, species.triangles[size_t(lod)], leaves, lod, {}};
}

dapple::base::Box boxOf(const Tree& tree) { return Prototype{"", {tree.bark, tree.leaves}}.box(); }

class EverySpecies : public testing::TestWithParam<std::string> {
protected:
    Species species = loadSpecies(GetParam());
};

double declination(const glm::dvec3& d) { return std::acos(d.z / glm::length(d)) * 180 / M_PI; }

}  // namespace

TEST_P(EverySpecies, stemsAreClosedSpheresWithinTheBudgetAtEveryLevel) {
    for (int lod = 0; lod < kLods; ++lod)
        for (uint64_t seed = 1; seed <= (lod == 0 ? 20 : 100); ++seed) {
            SCOPED_TRACE(testing::Message() << "level " << lod << ", seed " << seed);
            const Tree tree = growTree(species, level(species, seed, lod));
            const Connectivity bark = connectivity(tree.bark);
            ASSERT_TRUE(bark.closed()) << bark.boundary << " open, " << bark.nonManifold << " non-manifold, " << bark.degenerate << " degenerate";
            ASSERT_TRUE(bark.spheres);
            ASSERT_EQ(connectivity(tree.leaves).degenerate, 0u);
            expectUnitNormals(tree.bark);
            expectUnitNormals(tree.leaves);
            const size_t total = tree.bark.triangles() + tree.leaves.triangles(), budget = species.triangles[size_t(lod)];
            ASSERT_LE(total, budget);
            ASSERT_GE(total + 1, budget);
            ASSERT_GT(tree.leaves.triangles(), budget / 5);
        }
}

TEST_P(EverySpecies, solidLeavesAreClosedWherePolygonsAre) {
    for (int lod = 0; lod < kLods; ++lod)
        for (uint64_t seed = 1; seed <= 10; ++seed) {
            SCOPED_TRACE(testing::Message() << "level " << lod << ", seed " << seed);
            const Tree flat = growTree(species, level(species, seed, lod)), solid = growTree(species, level(species, seed, lod, LeafMode::solid));
            ASSERT_EQ(solid.bark.positions, flat.bark.positions);
            const size_t leaves = flat.leaves.triangles() / 2;
            ASSERT_EQ(solid.leaves.triangles(), 8 * leaves);
            for (size_t i = 0; i < leaves; ++i)
                for (size_t k = 0; k < 4; ++k) ASSERT_EQ(solid.leaves.positions[10 * i + k], flat.leaves.positions[4 * i + k]);
            const Connectivity c = connectivity(solid.leaves);
            ASSERT_TRUE(c.closed()) << c.boundary << " open, " << c.nonManifold << " non-manifold, " << c.degenerate << " degenerate";
            ASSERT_TRUE(c.spheres);
            ASSERT_EQ(c.components, leaves);
            expectUnitNormals(solid.leaves);
            double volume = 0;
            for (size_t i = 0; i < 24 * leaves; i += 3) {
                const Mesh& m = solid.leaves;
                volume += glm::dot(glm::dvec3(m.positions[m.indices[i]]), glm::cross(glm::dvec3(m.positions[m.indices[i + 1]]), glm::dvec3(m.positions[m.indices[i + 2]]))) / 6;
            }
            ASSERT_GT(volume, 0) << "outwards";
        }
}

TEST_P(EverySpecies, leavesGrowOutOfWoodNearBy) {
    for (const LeafMode mode : {LeafMode::polygon, LeafMode::card}) {
        const Tree tree = growTree(species, level(species, 3, 0, mode));
        size_t floating = 0;
        for (size_t v = 0; v < tree.leaves.positions.size(); v += 4 * 67) {
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
    const Connectivity c = connectivity(tree.bark);
    EXPECT_TRUE(c.closed() && c.spheres);
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
