#include "bench/plan.h"

#include "bench/fixture.h"

#include <set>

namespace dapple::bench {
namespace {

std::vector<std::string> ids(const Plan& plan) {
    std::vector<std::string> result;
    for (const PlannedPoint& p : plan.points) result.push_back(p.id);
    return result;
}

TEST(Plan, IsTheSameEveryTimeAndWhateverTheOrderOfKeys) {
    TestWorkbench one, two;
    EXPECT_EQ(makePlan(smallSweep(), one).csv(), makePlan(smallSweep(), two).csv());
    const std::string head = "question = \"?\"\nscenes = [\"a\"]\n[[technique]]\nname = \"instanced\"\n";
    const Sweep forwards = parseSweep(head + "size = [128, 256]\nrotations = [6, 12]\n", "s.toml");
    const Sweep backwards = parseSweep(head + "rotations = [6, 12]\nsize = [128, 256]\n", "s.toml");
    EXPECT_EQ(makePlan(forwards, one).csv(), makePlan(backwards, one).csv());
}

TEST(Plan, CsvHasTheSchemasColumns) {
    TestWorkbench bench;
    const CsvTable table(makePlan(smallSweep(), bench).csv(), "plan.csv");
    const std::vector<std::string> fixed{"point_id", "shard", "status", "reason", "scene", "technique", "view", "width", "height", "stress", "variant"};
    ASSERT_GT(table.header().size(), fixed.size());
    EXPECT_TRUE(std::equal(fixed.begin(), fixed.end(), table.header().begin()));
    for (size_t i = fixed.size(); i < table.header().size(); ++i) EXPECT_NO_THROW(shadow::axis(table.header()[i]));
    EXPECT_EQ(table.rows(), 8u);
    EXPECT_EQ(table.at(0, "size"), "");  // unshadowed has no such axis
    EXPECT_EQ(table.at(1, "size"), "256");
    EXPECT_EQ(table.at(1, "status"), "planned");
}

TEST(Plan, PointIdChangesWithEverythingThatDefinesThePoint) {
    PointSpec spec;
    spec.scene = "a";
    spec.technique = "uniform";
    spec.settings = shadow::technique("uniform").defaults;
    spec.view = "front";
    const std::string id = pointId(spec, 1);
    EXPECT_EQ(id.size(), 16u);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_EQ(pointId(spec, 1), id);

    std::set<std::string> seen{id};
    const auto isNew = [&](const PointSpec& changed, uint64_t hash) { EXPECT_TRUE(seen.insert(pointId(changed, hash)).second); };
    isNew(spec, 2);
    for (const auto& [axis, value] : spec.settings) {
        PointSpec changed = spec;
        changed.settings[axis] = value + "1";
        isNew(changed, 1);
    }
    PointSpec changed = spec;
    changed.technique = "focused", isNew(changed, 1);
    changed = spec, changed.view = "back", isNew(changed, 1);
    changed = spec, changed.width += 1, isNew(changed, 1);
    changed = spec, changed.height += 1, isNew(changed, 1);
    changed = spec, std::swap(changed.width, changed.height), isNew(changed, 1);
    changed = spec, changed.stressCase = "sun-zenith", isNew(changed, 1);

    PointSpec renamed = spec;  // the same content under another name is the same work
    renamed.scene = "b";
    EXPECT_EQ(pointId(renamed, 1), id);
}

TEST(Plan, ScenesWithOtherContentHaveOtherIds) {
    TestWorkbench before, after;
    after.contentSalt = 1;
    const auto a = ids(makePlan(smallSweep(), before)), b = ids(makePlan(smallSweep(), after));
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NE(a[i], b[i]);
}

TEST(Plan, PrunedPointsStayWithTheirReasonAndDoNotRun) {
    Sweep sweep = smallSweep();
    overrideAxis(sweep, "size=512,8192");
    TestWorkbench bench;
    bench.limitsOfGl.maxTextureSize = 4096;
    const Plan plan = makePlan(sweep, bench);
    size_t pruned = 0, compared = 0;
    for (const PlannedPoint& point : plan.points)
        if (point.spec.settings.contains("size") && point.spec.settings.at("size") == "8192") {
            ++pruned;
            EXPECT_NE(point.prunedBecause.find("8192"), std::string::npos);
        } else {
            EXPECT_EQ(point.prunedBecause, "");
        }
    EXPECT_EQ(pruned, 4u);
    for (const Comparison& c : plan.comparisons()) compared += c.points.size();
    EXPECT_EQ(compared + pruned, plan.points.size());
    EXPECT_NE(plan.csv().find(",pruned,"), std::string::npos);
}

TEST(Plan, AComparisonHoldsOneSceneCaseAndView) {
    Sweep sweep = smallSweep();
    sweep.views = {"front", "back"};
    sweep.stress = {"none", "sun-zenith"};
    TestWorkbench bench;
    const Plan plan = makePlan(sweep, bench);
    const auto comparisons = plan.comparisons();
    EXPECT_EQ(comparisons.size(), 8u);
    for (const Comparison& c : comparisons) {
        EXPECT_EQ(c.points.size(), 4u);
        for (const size_t i : c.points) {
            const PointSpec &first = plan.points[c.points[0]].spec, &other = plan.points[i].spec;
            EXPECT_EQ(first.scene + first.stressCase + first.view, other.scene + other.stressCase + other.view);
        }
    }
}

TEST(Plan, EachVariantIsASceneOfItsOwn) {
    Sweep sweep = smallSweep();
    sweep.sceneSettings = {"trees=5"};
    sweep.variants = {"", "sun.elevation=10", "sun.elevation=30; seed=4"};
    TestWorkbench bench;
    const Plan plan = makePlan(sweep, bench);
    const std::vector<std::string> all = ids(plan);
    EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), 24u);  // 2 scenes, 3 variants, 4 points
    EXPECT_EQ(plan.sceneHashes.size(), 6u);
    EXPECT_TRUE(plan.sceneHashes.contains("a[sun.elevation=10]"));
    const auto comparisons = plan.comparisons();
    ASSERT_EQ(comparisons.size(), 6u);
    const std::vector<std::string> settings[] = {{"trees=5"}, {"trees=5", "sun.elevation=10"}, {"trees=5", "sun.elevation=30", "seed=4"}};
    for (size_t c = 0; c < 6; ++c)
        for (const size_t i : comparisons[c].points) {
            EXPECT_EQ(plan.points[i].spec.scene, c < 3 ? "a" : "b");
            EXPECT_EQ(plan.points[i].spec.variant, sweep.variants[c % 3]);
            EXPECT_EQ(plan.points[i].spec.sceneSettings, settings[c % 3]);
        }
    const CsvTable table(plan.csv(), "plan.csv");
    EXPECT_EQ(table.at(0, "variant"), "");
    EXPECT_EQ(table.at(4, "variant"), "sun.elevation=10");
    EXPECT_EQ(makePlan(sweep, bench, PointFilter({"elevation=10", "uniform"})).points.size(), 4u);

    // A variant is what its settings make of the scene: said otherwise, they are the same points.
    sweep.sceneSettings = {"trees=5", "sun.elevation=10"};
    sweep.variants.clear();
    const std::vector<std::string> plain = ids(makePlan(sweep, bench));
    EXPECT_TRUE(std::equal(plain.begin(), plain.begin() + 4, all.begin() + 4));
}

TEST(Plan, TheSamePointTwiceIsMeasuredOnce) {
    TestWorkbench bench;
    Sweep sweep = smallSweep();
    const size_t once = makePlan(sweep, bench).points.size();
    sweep.entries.push_back(sweep.entries[1]);
    EXPECT_EQ(makePlan(sweep, bench).points.size(), once);
}

TEST(Plan, FiltersByTextOfTheWholePoint) {
    TestWorkbench bench;
    const auto count = [&](const std::vector<std::string>& patterns) { return makePlan(smallSweep(), bench, PointFilter(patterns)).points.size(); };
    EXPECT_EQ(count({"uniform"}), 4u);
    EXPECT_EQ(count({"UNIFORM|lispsm"}), 6u);
    EXPECT_EQ(count({"size=512"}), 4u);
    EXPECT_EQ(count({"size=512", "uniform"}), 2u);
    EXPECT_EQ(count({"^b "}), 4u);
    EXPECT_EQ(codeOf([&] { count({"nothing-like-this"}); }), base::ExitCode::usage);
    EXPECT_EQ(codeOf([&] { count({"("}); }), base::ExitCode::usage);
}

// Growing a city takes seconds.
TEST(Plan, ScenesThatTheFilterLeavesOutAreNotBuilt) {
    struct Counting : TestWorkbench {
        std::vector<std::string> built;
        SceneFacts sceneFacts(const std::string& scene, const std::vector<std::string>& settings, const std::string& stress) override {
            std::string name = scene;
            for (const std::string& setting : settings) name += " " + setting;
            built.push_back(name);
            return TestWorkbench::sceneFacts(scene, settings, stress);
        }
    } bench;
    Sweep sweep = smallSweep();
    sweep.views = {"front", "back"};
    sweep.variants = {"scale=1", "scale=16"};
    EXPECT_EQ(makePlan(sweep, bench, PointFilter({"^b ", "scale=16$", "back"})).points.size(), 4u);
    EXPECT_EQ(bench.built, std::vector<std::string>{"b scale=16"});
}

TEST(Plan, UnknownScenesAndViewsAreNamed) {
    TestWorkbench bench;
    Sweep sweep = smallSweep();
    sweep.views = {"frnt"};
    EXPECT_NE(messageOf([&] { makePlan(sweep, bench); }).find("'front'"), std::string::npos);
    sweep = smallSweep();
    sweep.scenes = {"d"};
    EXPECT_NE(messageOf([&] { makePlan(sweep, bench); }).find("unknown scene 'd'"), std::string::npos);
}

TEST(Plan, HashCoversPointsAndSampling) {
    TestWorkbench bench;
    Sweep sweep = smallSweep();
    const uint64_t hash = makePlan(sweep, bench).hash();
    EXPECT_EQ(makePlan(sweep, bench).hash(), hash);
    sweep.sampling.minBlocks += 1;
    EXPECT_NE(makePlan(sweep, bench).hash(), hash);
    EXPECT_NE(makePlan(smallSweep(), bench, PointFilter({"uniform"})).hash(), hash);
}

}  // namespace
}  // namespace dapple::bench
