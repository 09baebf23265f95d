#include "base/error.h"
#include "base/file.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>
#include <tuple>

using namespace dapple::scenegen;
using dapple::base::UsageError;
using testing::HasSubstr;

namespace {

std::string errorOf(const std::function<void()>& call) {
    try {
        call();
    } catch (const UsageError& e) {
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "one line";
        return e.what();
    }
    return "no error";
}

/// Loads a recipe of this text from a file.
Scene load(const std::string& text, const std::vector<std::string>& settings = {}) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "recipe_under_test.toml";
    dapple::base::writeFile(path, text);
    return loadScene(path.string(), settings);
}

const std::string kForest = R"(description = "x"
trees = 5
[ground]
size = 60
[[species]]
name = "oak"
triangles = 2500
[path]
views = 2
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) { return text.replace(text.find(from), from.size(), to); }

TEST(Recipe, ARadiusLeavesOutWhatBeginsFartherAway) {
    const Scene all = loadScene("city-vienna", {"scale=0.05"}), near = loadScene("city-vienna", {"scale=0.05", "radius=60"});
    ASSERT_EQ(near.views.size(), all.views.size());
    const glm::dvec2 eye(all.views[0].eye);
    std::vector<Instance> expected;
    for (const Instance& i : all.instances) {
        const dapple::base::Box box = instanceBox(all.prototypes[i.prototype].box(), i);
        const glm::dvec2 lo(box.lo), hi(box.hi), gap = glm::max(glm::max(lo - eye, eye - hi), glm::dvec2(0));
        if (glm::length(gap) <= 60) expected.push_back(i);
    }
    ASSERT_LT(expected.size(), all.instances.size());
    ASSERT_EQ(near.instances.size(), expected.size());
    for (size_t k = 0; k < expected.size(); ++k) EXPECT_EQ(near.instances[k].translation, expected[k].translation) << k;
    for (const Motion& m : near.motions) EXPECT_EQ(near.instances[m.instance].translation, m.at(0).translation);
}

}  // namespace

TEST(Library, everyListedSceneLoads) {
    for (const SceneEntry& entry : listScenes()) {
        SCOPED_TRACE(entry.name);
        EXPECT_FALSE(entry.description.empty());
        const Scene scene = loadScene(entry.name);
        EXPECT_EQ(scene.name, entry.name);
        EXPECT_FALSE(scene.views.empty());
    }
}

TEST(Library, forest105IsThePapersScene) {
    const Scene scene = loadScene("forest-105");
    size_t trees = 0;
    for (const Instance& instance : scene.instances) {
        const Prototype& p = scene.prototypes[instance.prototype];
        if (!p.castsShadow) continue;
        ++trees;
        EXPECT_NEAR(double(p.triangles()), 36000, 0.05 * 36000);
        EXPECT_GE(instance.scale, 0.8f);
        EXPECT_LE(instance.scale, 1.25f);
    }
    EXPECT_EQ(trees, 105u);
    const Facts f = scene.facts();
    EXPECT_NEAR(double(f.triangles), 3.8e6, 0.05 * 3.8e6);
    EXPECT_TRUE(f.rotated);
    EXPECT_TRUE(f.scaled);
    EXPECT_FALSE(f.alphaTested);
    EXPECT_GE(scene.views.size(), 5u);
    for (const View& v : scene.views) EXPECT_NEAR(glm::length(v.forward), 1, 1e-12) << v.name;
}

TEST(Library, forestSmallHasBothKindsOfLeaves) {
    const Scene scene = loadScene("forest-small");
    EXPECT_TRUE(scene.facts().alphaTested);
    bool opaque = false;
    for (const Prototype& p : scene.prototypes) {
        EXPECT_LT(p.triangles(), 4100u);
        for (const Mesh& m : p.meshes) opaque |= p.castsShadow && !scene.materials[m.material].alphaTested;
    }
    EXPECT_TRUE(opaque);
}

TEST(Library, walkersHaveClearSight) {
    const Scene scene = loadScene("forest-small");
    for (const View& view : scene.views) {
        if (!view.name.starts_with("walk")) continue;
        for (const Instance& i : scene.instances) {
            if (!scene.prototypes[i.prototype].castsShadow) continue;
            EXPECT_GT(glm::length(glm::dvec2(view.eye) - glm::dvec2(i.translation)), 1.5) << view.name << " stands in a tree";
        }
    }
}

TEST(Library, factsOfTheExtremes) {
    EXPECT_EQ(loadScene("nothing").facts().triangles, 0u);
    EXPECT_FALSE(loadScene("nothing").facts().receivers);
    EXPECT_FALSE(loadScene("empty").facts().casters);
    EXPECT_TRUE(loadScene("empty").facts().receivers);
    for (const char* name : {"box", "sphere", "slab"}) EXPECT_TRUE(loadScene(name).facts().closed) << name;

    // Casters: instances, and the size of the smallest one's box.
    const auto casters = [](const Scene& scene) {
        size_t count = 0;
        glm::vec3 least(std::numeric_limits<float>::infinity());
        for (const Instance& i : scene.instances) {
            const Prototype& p = scene.prototypes[i.prototype];
            if (!p.castsShadow) continue;
            ++count;
            least = glm::min(least, 2.0f * p.box().halfSize());
        }
        return std::pair(count, least);
    };
    // To the grid of a box a metre high, which is 1/16 mm.
    const auto near = [](const glm::vec3& a, const glm::vec3& b) { return glm::all(glm::lessThan(glm::abs(a - b), glm::vec3(0.03f) * b)); };
    const auto needles = casters(loadScene("extreme-needles")), single = casters(loadScene("extreme-single")), tiny = casters(loadScene("extreme-millimetre"));
    EXPECT_EQ(needles.first, 2000u);
    EXPECT_TRUE(near(needles.second, {0.002f, 0.002f, 1.5f}));
    EXPECT_EQ(single.first, 1u);
    EXPECT_TRUE(near(single.second, {0.001f, 0.001f, 1}));
    EXPECT_EQ(tiny.first, 1u);
    EXPECT_TRUE(near(tiny.second, glm::vec3(0.001f)));
    const dapple::base::Box wide = loadScene("extreme-100km").facts().box;
    EXPECT_GE(wide.hi.x - wide.lo.x, 99'999);
    EXPECT_GE(wide.hi.y - wide.lo.y, 99'999);
    EXPECT_GE(glm::length(glm::dvec2(loadScene("extreme-far-origin").origin)), 1e6);

    const Scene crowd = loadScene("extreme-crowd");
    EXPECT_EQ(casters(crowd).first, 100'000u);
    std::set<std::tuple<float, float, float>> places;
    for (const Instance& i : crowd.instances)
        if (crowd.prototypes[i.prototype].castsShadow) places.emplace(i.translation.x, i.translation.y, i.translation.z);
    EXPECT_EQ(places.size(), 1u);
}

TEST(Library, sliversHaveNoAreaAndLayersShareTheirPlanes) {
    size_t flat = 0;
    for (const Prototype& p : loadScene("extreme-slivers").prototypes)
        for (const Mesh& m : p.meshes)
            for (size_t i = 0; i < m.indices.size(); i += 3) {
                const glm::dvec3 a = m.positions[m.indices[i]], b = m.positions[m.indices[i + 1]], c = m.positions[m.indices[i + 2]];
                // The middle of a side is on it but for its rounding to the grid.
                flat += glm::length(glm::cross(b - a, c - a)) <= 2e-3 * (glm::length(b - a) + glm::length(c - a));
            }
    EXPECT_EQ(flat, 10'000u);

    // Of boxes, which planes of an axis two share where they overlap in the others.
    const Scene layers = loadScene("extreme-coplanar");
    std::vector<dapple::base::Box> boxes;
    for (const Instance& i : layers.instances)
        if (layers.prototypes[i.prototype].castsShadow) boxes.push_back(instanceBox(layers.prototypes[i.prototype].box(), i));
    std::set<std::pair<int, bool>> shared;  // axis, upper side
    size_t onGround = 0;
    for (size_t i = 0; i < boxes.size(); ++i) {
        onGround += boxes[i].lo.z == 0;
        for (size_t k = 0; k < i; ++k)
            for (int axis = 0; axis < 3; ++axis) {
                const int u = (axis + 1) % 3, v = (axis + 2) % 3;
                const auto overlap = [&](int c) { return std::min(boxes[i].hi[c], boxes[k].hi[c]) > std::max(boxes[i].lo[c], boxes[k].lo[c]); };
                if (!overlap(u) || !overlap(v)) continue;
                if (boxes[i].hi[axis] == boxes[k].hi[axis]) shared.emplace(axis, true);
                if (boxes[i].lo[axis] == boxes[k].lo[axis]) shared.emplace(axis, false);
            }
    }
    EXPECT_TRUE(shared.contains({2, true})) << "tops";
    EXPECT_GE(onGround, 1u);
    EXPECT_GE(shared.size(), 3u) << "tops, feet and a side";
}

/// What is scattered or laid out grows with the area; what is placed by hand stays as it is, and so does ground that was surveyed.
TEST(Library, scaleMultipliesWhatIsScattered) {
    const auto casting = [](const Scene& scene) {
        double triangles = 0;
        for (const Instance& i : scene.instances)
            if (const Prototype& p = scene.prototypes[i.prototype]; p.castsShadow && !p.name.starts_with("terrain")) triangles += double(p.triangles());
        return triangles;
    };
    const std::set<std::string> grow{"city-manhattan", "city-vienna", "city-vienna-night", "forest-105", "forest-card", "forest-small",
                                     "forest-two-suns", "jacksboro", "level-outdoor"};
    size_t seen = 0;
    for (const SceneEntry& entry : listScenes()) {
        SCOPED_TRACE(entry.name);
        const double small = casting(loadScene(entry.name, {"scale=0.05"})), large = casting(loadScene(entry.name, {"scale=0.2"}));
        if (!grow.contains(entry.name)) {
            EXPECT_EQ(small, large);
            continue;
        }
        ++seen;
        // Whole trees: a small forest's 1.25 become one. A city's edge has no streets beyond it.
        EXPECT_GT(large / small, 3);
        EXPECT_LT(large / small, 5.1);
    }
    EXPECT_EQ(seen, grow.size());
}

/// Files that recipes name are height maps and footprints, never recipes: there is no way round in a circle.
TEST(Recipe, itselfIsNoHeightMapAndNoFootprints) {
    const std::string file = "file = \"recipe_under_test.toml\"\n", footprints = "footprints = \"recipe_under_test.toml\"\n";
    for (const std::string& table : {"[terrain]\n" + file, "[city]\n" + footprints})
        EXPECT_THAT(errorOf([&] { load("description = \"x\"\n" + table); }), HasSubstr("recipe_under_test.toml")) << table;
}

TEST(Recipe, originMovesNothingElse) {
    const Scene here = load(kForest), there = load("origin = [1e6, -2e6, 300]\n" + kForest);
    EXPECT_EQ(there.origin, glm::dvec3(1e6, -2e6, 300));
    ASSERT_EQ(here.instances.size(), there.instances.size());
    for (size_t i = 0; i < here.instances.size(); ++i) EXPECT_EQ(here.instances[i].translation, there.instances[i].translation);
    EXPECT_EQ(here.views[0].eye, there.views[0].eye);
}

TEST(Recipe, settingsOverrideAndAddKeys) {
    EXPECT_EQ(load(kForest, {"trees=9"}).instances.size(), 10u);
    EXPECT_EQ(load(kForest, {"ground.undulation=0.5", "seed=4"}).prototypes[0].name, "ground");
    EXPECT_EQ(loadScene("box", {"sun.elevation=12"}).sun.elevation, 12);
    EXPECT_EQ(loadScene("forest-small", {"species.1.leaves=polygon"}).facts().alphaTested, false);
    EXPECT_EQ(loadScene("box", {"origin=[1, 2, 3]"}).origin, glm::dvec3(1, 2, 3));
}

TEST(Recipe, sharesAreKeptToWithinOneTree) {
    const Scene scene = load(replaced(kForest, "trees = 5", "trees = 12") + "[[species]]\nname = \"fir\"\nshare = 3\ntriangles = 2500\n");
    size_t firs = 0;
    for (const Instance& i : scene.instances) firs += scene.prototypes[i.prototype].name == "fir";
    EXPECT_EQ(firs, 9u);
}

TEST(Recipe, individualsDiffer) {
    const Scene scene = load(replaced(kForest, "name = \"oak\"", "name = \"oak\"\nindividuals = 3"));
    ASSERT_EQ(scene.prototypes.size(), 4u);
    EXPECT_NE(scene.prototypes[1].box().hi, scene.prototypes[2].box().hi);
}

TEST(Recipe, badValuesNameFileLineAndKey) {
    struct Bad {
        const char *from, *to, *expected;
    };
    for (const Bad& bad : std::initializer_list<Bad>{
             {"trees = 5", "trees = 0", ":2: trees: 0 is outside"},
             {"trees = 5", "trees = -3", ":2: trees: -3 is outside"},
             {"trees = 5", "trees = nan", ":2: trees: must be a whole number"},
             {"trees = 5", "trees = 5000000000", ":2: trees: 5000000000 is outside"},
             {"trees = 5", "trees = 1000000000\nscale = 9999", ":2: trees: 9999000000000 trees need about 1303721.2 GiB while they are made"},
             {"triangles = 2500", "triangles = 10000000\nindividuals = 1000", ":8: individuals: 1000 individuals of 10000000 triangles need about"},
             {"size = 60", "size = nan", ":4: size: must be finite"},
             {"size = 60", "size = -1", ":4: size: -1 is outside"},
             {"size = 60", "size = 60\nundulatoin = 2", ":5: unknown key 'undulatoin'; did you mean 'undulation'?"},
             {"\"oak\"", "\"oka\"", ":6: name: unknown species 'oka'; did you mean 'oak'?"},
             {"triangles = 2500", "triangles = 10", ":7: triangles: species oak: 10 triangles are too few"},
             {"triangles = 2500", "leaves = \"needle\"", ":7: leaves: 'needle' is none of"},
             {"triangles = 2500", "scale = [2, 1]", ":7: scale: must be"},
             {"triangles = 2500", "lod = 3", ":7: lod: 3 is outside"},
             {"triangles = 2500", "keep = 0", ":7: keep: 0 is outside"},
             {"views = 2", "views = 0", ":9: views: 0 is outside"},
             {"views = 2", "near = 5\nfar = 1", ":10: far: must be beyond near"},
         })
        EXPECT_THAT(errorOf([&] { load(replaced(kForest, bad.from, bad.to)); }), HasSubstr(std::string("recipe_under_test.toml") + bad.expected)) << bad.to;
}

TEST(Recipe, badValuesSayWhatIsWrong) {
    EXPECT_THAT(errorOf([] { load(replaced(kForest, "description = \"x\"", "")); }), HasSubstr("description: is required"));
    EXPECT_THAT(errorOf([] { load(replaced(kForest, "trees = 5", "")); }), HasSubstr("trees: is required"));
    EXPECT_THAT(errorOf([] { load(replaced(kForest, "[path]\nviews = 2\n", "")); }), HasSubstr("at least one [[view]]"));
    EXPECT_THAT(errorOf([] { load("description = \"x\"\n[[species]]\nname = \"oak\"\n"); }), HasSubstr("need a [ground]"));
    EXPECT_THAT(errorOf([] { load("description = \"x\"\n[[primitive]]\nkind = \"cube\"\nposition = [0,0,0]\n"); }), HasSubstr("'cube' is none of box"));
    EXPECT_THAT(errorOf([] { load("description = \"x\"\n[[primitive]]\nkind = \"box\"\nposition = [0,0,0]\nsize = [1,0,1]\n"); }), HasSubstr(":5: size"));
    EXPECT_THAT(errorOf([] { load("description = \n"); }), HasSubstr("not valid TOML"));
}

TEST(Recipe, countsThatMultiplyAreGuarded) {
    const std::string view = "[[view]]\nname = \"v\"\neye = [0, 0, 9]\ntarget = [1, 0, 0]\n";
    const auto refusal = [&](const std::string& text) { return errorOf([&] { load("description = \"x\"\n" + text + view); }); };
    EXPECT_THAT(refusal("scale = 10000\n[ground]\ncells = 2000\n"), HasSubstr("cells: 200000 × 200000 cells of ground need about"));
    EXPECT_THAT(refusal("scale = 10000\n[terrain]\ncells = 16384\n"), HasSubstr("cells: 1638400 × 1638400 cells of terrain need about"));
    EXPECT_THAT(refusal("scale = 10000\n[terrain]\ncells = 8\ntiles = 1\ndroplets = 1000000\n"), HasSubstr("droplets: 10000000000 droplets"));
    // Where a machine has the memory for it, a limit of its own may not leave it.
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
    rlimit less = before;
    less.rlim_cur = std::min<rlim_t>(before.rlim_max, rlim_t(4) << 30);
    ASSERT_EQ(::setrlimit(RLIMIT_AS, &less), 0);
    const std::string primitive = "[[primitive]]\nposition = [0, 0, 0]\nsize = [1, 1, 1]\n";
    EXPECT_THAT(refusal(primitive + "kind = \"box\"\ncopies = 100000000\n"), HasSubstr("copies: 100000000 copies need about"));
    less.rlim_cur = std::min<rlim_t>(before.rlim_max, rlim_t(3) << 29);
    ASSERT_EQ(::setrlimit(RLIMIT_AS, &less), 0);
    EXPECT_THAT(refusal(primitive + "kind = \"slivers\"\ntriangles = 10000000\n"), HasSubstr("triangles: 10000000 slivers need about"));
    ::setrlimit(RLIMIT_AS, &before);
}

TEST(Recipe, badSettingsNameThemselves) {
    EXPECT_THAT(errorOf([] { loadScene("forest-small", {"tree=3"}); }), HasSubstr("unknown key 'tree'; did you mean 'trees'?"));
    EXPECT_THAT(errorOf([] { loadScene("forest-small", {"trees=0"}); }), HasSubstr("setting 'trees=0': trees: 0 is outside"));
    EXPECT_THAT(errorOf([] { loadScene("forest-small", {"grund.size=3"}); }), HasSubstr("unknown key 'grund'; did you mean 'ground'?"));
    EXPECT_THAT(errorOf([] { loadScene("forest-small", {"species.7.share=3"}); }), HasSubstr("species.7"));
    EXPECT_THAT(errorOf([] { loadScene("forest-small", {"trees"}); }), HasSubstr("must be key=value"));
    EXPECT_THAT(errorOf([] { loadScene("forest-small", {"sun.elevation=high"}); }), HasSubstr("must be a number"));
}

TEST(Library, unknownScenesNameTheNearest) {
    EXPECT_THAT(errorOf([] { loadScene("forest-smal"); }), HasSubstr("did you mean 'forest-small'?"));
    EXPECT_NE(errorOf([] { loadScene("missing.toml"); }), "no error");
    EXPECT_NE(errorOf([] { loadScene(""); }), "no error");
}
