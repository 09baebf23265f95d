#include "bench/run.h"

#include "bench/fixture.h"

#include <nlohmann/json.hpp>

#include <map>
#include <set>

namespace dapple::bench {
namespace {

struct SmallRun {
    TemporaryFolder folder;
    TestWorkbench bench;
    Plan plan;
    explicit SmallRun(const Sweep& sweep = smallSweep()) : plan(makePlan(sweep, bench)) {}
    std::string out() const { return (folder.path / "out").string(); }
    std::string file(const char* name) const { return base::readFile(folder.path / "out" / name); }
    CsvTable table(const char* name) const { return {file(name), name}; }
    RunOutcome go() { return runPlan(plan, bench, {.folder = out(), .resume = false}); }
};

TEST(Run, WritesExactlyTheSchemasColumnsAndFiles) {
    SmallRun run;
    EXPECT_TRUE(run.go().clean());
    const auto header = [&](const char* name) {
        const std::string text = run.file(name);
        return text.substr(0, text.find('\n'));
    };
    EXPECT_EQ(header("metrics.csv"), "schema,run_id,point_id,scene,technique,view,pass,metric,unit,better,n,median,ci_lo,ci_hi,q1,q3,min,max,backend,status,flags");
    EXPECT_EQ(header("samples.csv"), "run_id,point_id,process,block,order,arm,frame,pass,metric,value,flags");
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(run.out())) names.insert(entry.path().filename());
    EXPECT_EQ(names, (std::set<std::string>{"plan.csv", "metrics.csv", "samples.csv", "run.json", "manifest.json"}));
    EXPECT_EQ(run.file("plan.csv"), run.plan.csv());
    const auto json = nlohmann::json::parse(run.file("run.json"));
    for (const char* key : {"schema", "argv", "build", "machine", "seeds", "hashes", "start", "end", "run_id", "plan_hash", "backend"})
        EXPECT_TRUE(json.contains(key)) << key;
}

TEST(Run, ATimerThatItsSelfTestRejectedIsNamedOnEveryRowAndOnce) {
    const auto flagged = [](const std::string& rejected) {
        SmallRun run;
        run.bench.rejected = rejected;
        testing::internal::CaptureStderr();
        run.go();
        const std::string said = testing::internal::GetCapturedStderr();
        EXPECT_EQ(said.find("failed its self-test (it sees a tenth of the wall)") != std::string::npos, !rejected.empty()) << said;
        size_t values = 0, withFlag = 0;
        for (const char* name : {"metrics.csv", "samples.csv"}) {
            const CsvTable table = run.table(name);
            for (size_t i = 0; i < table.rows(); ++i) {
                const bool has = (";" + table.at(i, "flags") + ";").find(";timer_rejected;") != std::string::npos;
                const bool value = std::string(name) == "samples.csv" || table.at(i, "status") == "ok";
                values += value;
                withFlag += has;
                EXPECT_EQ(has, value && !rejected.empty()) << name << " " << i;
            }
        }
        EXPECT_GT(values, 100u);
        return withFlag;
    };
    EXPECT_GT(flagged("it sees a tenth of the wall"), 100u);
    EXPECT_EQ(flagged(""), 0u);
}

TEST(Run, EveryPointHasItsRowsAndKeysAreUnique) {
    SmallRun run;
    run.go();
    const CsvTable table = run.table("metrics.csv");
    std::set<std::string> keys, known;
    std::map<std::string, std::set<std::string>> metricsOf;
    for (const auto& infos : {measure::metrics(), runMetrics()})
        for (const auto& info : infos) known.insert(std::string(info.name));
    for (size_t i = 0; i < table.rows(); ++i) {
        EXPECT_TRUE(keys.insert(table.at(i, "point_id") + "|" + table.at(i, "pass") + "|" + table.at(i, "metric")).second) << i;
        EXPECT_TRUE(known.contains(table.at(i, "metric"))) << table.at(i, "metric");
        EXPECT_EQ(table.at(i, "median").find("nan"), std::string::npos);
        EXPECT_EQ(table.at(i, "backend"), "fake");
        metricsOf[table.at(i, "point_id")].insert(table.at(i, "metric"));
    }
    ASSERT_EQ(metricsOf.size(), run.plan.points.size());
    for (const auto& [id, names] : metricsOf)
        for (const char* metric : {"frame_time", "pass_time", "first_frame", "error", "texture_bytes"}) EXPECT_TRUE(names.contains(metric)) << metric;
}

TEST(Run, LeftOutPassesAndFallbacksAreRowsWithReasons) {
    Sweep sweep = smallSweep();
    sweep.stress = {"none", "parallel-0"};
    SmallRun run(sweep);
    EXPECT_TRUE(run.go().clean());
    const CsvTable table = run.table("metrics.csv");
    size_t leftOut = 0, fallbacks = 0;
    for (size_t i = 0; i < table.rows(); ++i) {
        const std::string& metric = table.at(i, "metric");
        if (metric != "left_out" && metric != "fallback") continue;
        EXPECT_EQ(table.at(i, "status"), metric);
        EXPECT_FALSE(table.at(i, "flags").empty());
        EXPECT_EQ(table.at(i, "median"), "");
        EXPECT_EQ(table.at(i, "pass").empty(), metric == "fallback");
        (metric == "fallback" ? fallbacks : leftOut) += 1;
    }
    EXPECT_EQ(leftOut, 2u * 4u);   // two passes of unshadowed in four comparisons
    EXPECT_EQ(fallbacks, 2u);      // lispsm in the parallel case of two scenes
}

TEST(Run, TwiceGivesTheSameDeterministicColumnsAndRowOrder) {
    SmallRun one, two;
    one.go();
    two.go();
    EXPECT_EQ(deterministicPart(one.folder.path / "out/metrics.csv"), deterministicPart(two.folder.path / "out/metrics.csv"));
    EXPECT_EQ(one.file("plan.csv"), two.file("plan.csv"));
    EXPECT_NE(one.table("metrics.csv").at(0, "run_id"), two.table("metrics.csv").at(0, "run_id"));
}

/// ABBA: within a round of one block per arm and its mirror image, the places of an arm's two blocks add up to
/// the same for all arms, so that a linear drift hits all alike. And no arm's blocks are bunched together.
TEST(Run, BlocksOfOneComparisonAreInterleavedAbba) {
    SmallRun run;
    run.go();
    const CsvTable samples = run.table("samples.csv");
    std::map<std::string, std::string> sceneOf;
    for (const PlannedPoint& p : run.plan.points) sceneOf[p.id] = p.spec.scene;
    std::map<std::string, std::map<std::string, std::map<int, int>>> order;  // scene, arm, block → place
    for (size_t i = 0; i < samples.rows(); ++i)
        order[sceneOf.at(samples.at(i, "point_id"))][samples.at(i, "arm")][std::stoi(samples.at(i, "block"))] = std::stoi(samples.at(i, "order"));
    ASSERT_EQ(order.size(), 2u);
    for (const auto& [scene, arms] : order) {
        ASSERT_EQ(arms.size(), 4u);
        const size_t rounds = arms.begin()->second.size() / 2;
        ASSERT_GE(rounds, 5u);
        for (int round = 0; round < int(rounds); ++round) {
            std::set<int> sums, places;
            for (const auto& [arm, blocks] : arms) {
                sums.insert(blocks.at(2 * round) + blocks.at(2 * round + 1));
                places.insert(blocks.at(2 * round));
                places.insert(blocks.at(2 * round + 1));
            }
            EXPECT_EQ(sums.size(), 1u);
            EXPECT_EQ(places.size(), 8u);
            EXPECT_EQ(*places.rbegin() - *places.begin(), 7);
        }
    }
}

TEST(Run, RatiosToTheUnshadowedFrameAreThoseOfTheTimes) {
    SmallRun run;
    run.go();
    const CsvTable table = run.table("metrics.csv");
    std::map<std::string, std::map<std::string, double>> values;  // scene|point → metric → median
    std::map<std::string, double> unshadowed;
    for (size_t i = 0; i < table.rows(); ++i) {
        if (!table.at(i, "pass").empty() || table.at(i, "median").empty()) continue;
        const double value = std::stod(table.at(i, "median"));
        values[table.at(i, "scene") + "|" + table.at(i, "point_id")][table.at(i, "metric")] = value;
        if (table.at(i, "technique") == "unshadowed" && table.at(i, "metric") == "frame_time") unshadowed[table.at(i, "scene")] = value;
    }
    size_t compared = 0;
    for (auto& [key, point] : values)
        if (point.contains("to_unshadowed")) {
            ++compared;
            // The noise is ±2 % of a frame; medians of ten blocks are far closer.
            EXPECT_NEAR(point["to_unshadowed"], point["frame_time"] / unshadowed[key.substr(0, 1)], 0.02 * point["to_unshadowed"]);
        }
    EXPECT_EQ(compared, 6u);
}

TEST(Run, AFailedPointIsARowAndTheRunGoesOn) {
    for (const bool whileSampling : {false, true}) {
        SmallRun run;
        int frames = 0;
        const auto fail = [&](const PointSpec& spec) {
            if (spec.scene == "a" && spec.technique == "lispsm" && (!whileSampling || ++frames > 20))
                throw base::Error(base::ExitCode::failed, "no,\nmemory");
        };
        (whileSampling ? run.bench.onFrame : run.bench.onOpen) = fail;
        const RunOutcome outcome = run.go();
        EXPECT_EQ(outcome.points, 8u);
        EXPECT_EQ(outcome.failed, 1u);
        EXPECT_EQ(codeOf([&] { requireClean(outcome, run.out()); }), base::ExitCode::failed);
        const CsvTable table = run.table("metrics.csv");
        size_t rowsOfFailed = 0, measured = 0;
        for (size_t i = 0; i < table.rows(); ++i) {
            measured += table.at(i, "metric") == "frame_time";
            if (table.at(i, "scene") != "a" || table.at(i, "technique") != "lispsm") continue;
            ++rowsOfFailed;
            EXPECT_EQ(table.at(i, "status"), "failed");
            EXPECT_EQ(table.at(i, "flags"), "no, memory");
        }
        EXPECT_EQ(rowsOfFailed, 1u);
        EXPECT_EQ(measured, 7u);
    }
}

TEST(Run, InvalidTimesAreFlaggedAndNotClean) {
    struct Lossy : TestWorkbench {
        struct Point : OpenPoint {
            std::unique_ptr<OpenPoint> inner;
            const std::vector<std::string>& passNames() const override { return inner->passNames(); }
            void submitFrame(bool perPass) override { inner->submitFrame(perPass); }
            std::vector<measure::FrameTimes> drain() override {
                auto frames = inner->drain();
                for (auto& frame : frames) frame.flags.push_back("gl_error");
                return frames;
            }
            std::vector<Figure> counters() override { return {{"", "error", "", "lower", std::nan(""), ""}}; }
            std::vector<Figure> errors() override { return {}; }
            std::vector<PassNote> leftOut() const override { return {}; }
            std::string fallback() const override { return ""; }
        };
        std::unique_ptr<OpenPoint> open(const PointSpec& spec) override {
            auto point = std::make_unique<Point>();
            point->inner = TestWorkbench::open(spec);
            return point;
        }
    } bench;
    TemporaryFolder folder;
    const Plan plan = makePlan(smallSweep(), bench, PointFilter({"^a unshadowed"}));
    const RunOutcome outcome = runPlan(plan, bench, {.folder = (folder.path / "out").string(), .resume = false});
    EXPECT_EQ(outcome.failed, 0u);
    EXPECT_GE(outcome.invalid, 2u);
    const CsvTable table(base::readFile(folder.path / "out/metrics.csv"), "metrics.csv");
    for (size_t i = 0; i < table.rows(); ++i) {
        if (table.at(i, "metric") == "frame_time") {
            EXPECT_EQ(table.at(i, "status"), "invalid");
            EXPECT_NE(table.at(i, "flags").find("gl_error"), std::string::npos);
            EXPECT_EQ(table.at(i, "median"), "");
        }
        if (table.at(i, "metric") == "error") {
            EXPECT_EQ(table.at(i, "flags"), "nonfinite");
            EXPECT_EQ(table.at(i, "median"), "");
        }
    }
}

TEST(Run, ASweepWithoutAnyPointLeftIsRefused) {
    Sweep sweep = smallSweep();
    TestWorkbench bench;
    bench.limitsOfGl.maxTextureSize = 128;
    TemporaryFolder folder;
    const Plan plan = makePlan(sweep, bench, PointFilter({"uniform"}));
    const RunOptions options{.folder = (folder.path / "out").string(), .resume = false};
    EXPECT_NE(messageOf([&] { runPlan(plan, bench, options); }).find("size 256 is beyond"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder.path / "out"));
}

TEST(Run, CountersAndErrorsComeAfterTheTimedFrames) {
    // Else they would warm up what the first frame's time is to show.
    struct Watched : TestWorkbench {
        struct Point : OpenPoint {
            std::unique_ptr<OpenPoint> inner;
            int frames = 0;
            const std::vector<std::string>& passNames() const override { return inner->passNames(); }
            void submitFrame(bool perPass) override { ++frames, inner->submitFrame(perPass); }
            std::vector<measure::FrameTimes> drain() override { return inner->drain(); }
            std::vector<Figure> counters() override { return {{"", "draw_calls", "calls", "lower", frames, ""}}; }
            std::vector<Figure> errors() override { return {}; }
            std::vector<PassNote> leftOut() const override { return {}; }
            std::string fallback() const override { return ""; }
        };
        std::unique_ptr<OpenPoint> open(const PointSpec& spec) override {
            auto point = std::make_unique<Point>();
            point->inner = TestWorkbench::open(spec);
            return point;
        }
    } bench;
    TemporaryFolder folder;
    runPlan(makePlan(smallSweep(), bench, PointFilter({"^a "})), bench, {.folder = (folder.path / "out").string(), .resume = false});
    const CsvTable table(base::readFile(folder.path / "out/metrics.csv"), "metrics.csv");
    size_t found = 0;
    for (size_t i = 0; i < table.rows(); ++i)
        if (table.at(i, "metric") == "draw_calls") {
            ++found;
            EXPECT_GT(std::stod(table.at(i, "median")), 50);
        }
    EXPECT_EQ(found, 4u);
}

TEST(Run, ReleasesASceneAfterItsLastPoint) {
    SmallRun run;
    run.bench.onOpen = [&](const PointSpec& spec) { EXPECT_EQ(run.bench.released.size(), spec.scene == "a" ? 0u : 1u); };
    run.go();
    EXPECT_EQ(run.bench.released, (std::vector<std::string>{"a", "b"}));
}

}  // namespace
}  // namespace dapple::bench
