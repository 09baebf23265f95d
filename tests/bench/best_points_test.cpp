#include "bench/best_points.h"

#include "bench/fixture.h"
#include "bench/run.h"

#include <random>
#include <set>

namespace dapple::bench {
namespace {

std::vector<MeasuredPoint> randomPoints(unsigned seed, size_t count) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<MeasuredPoint> points;
    for (size_t i = 0; i < count; ++i) points.push_back({std::to_string(i), uniform(random), uniform(random), {}, {}});
    return points;
}

bool dominated(const MeasuredPoint& p, const std::vector<MeasuredPoint>& all) {
    return std::any_of(all.begin(), all.end(), [&](const MeasuredPoint& q) { return q.frameMs < p.frameMs && q.error < p.error; });
}

TEST(ParetoFront, IsWhatNoOtherPointBeats) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        const std::vector<MeasuredPoint> all = randomPoints(seed, 17);
        std::set<std::string> expected, found;
        for (const MeasuredPoint& p : all)
            if (!dominated(p, all)) expected.insert(p.pointId);
        const std::vector<MeasuredPoint> front = paretoFront(all);
        for (const MeasuredPoint& p : front) found.insert(p.pointId);
        EXPECT_EQ(found, expected);
        for (size_t i = 1; i < front.size(); ++i) EXPECT_LT(front[i - 1].frameMs, front[i].frameMs);
    }
    EXPECT_TRUE(paretoFront({}).empty());
}

TEST(MeasuredPoints, AreReadFromARunWithoutItsBaselines) {
    TemporaryFolder folder;
    TestWorkbench bench;
    const Plan plan = makePlan(smallSweep(), bench, PointFilter({"^a "}));
    runPlan(plan, bench, {.folder = (folder.path / "out").string(), .resume = false});
    const auto points = measuredPoints(folder.path / "out/metrics.csv");
    ASSERT_EQ(points.size(), 3u);
    for (const MeasuredPoint& p : points) {
        EXPECT_GT(p.frameMs, 4);
        EXPECT_GT(p.error, 0);
        EXPECT_TRUE(p.overUnshadowed.has_value());
        EXPECT_GT(p.textureBytes.value_or(0), 0);
    }
    const std::string table = pointsTable(points, plan);
    EXPECT_NE(table.find("uniform"), std::string::npos);
    EXPECT_NE(table.find("size=256"), std::string::npos);
    EXPECT_EQ(table.find("unshadowed "), table.find("unshadowed  textures"));  // only in the heading
}

}  // namespace
}  // namespace dapple::bench
