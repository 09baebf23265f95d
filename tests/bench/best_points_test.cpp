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

TEST(BestPoints, AreTheParetoFrontBeforeAnythingElse) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        const std::vector<MeasuredPoint> all = randomPoints(seed, 17);
        std::set<std::string> front, best;
        for (const MeasuredPoint& p : all)
            if (!dominated(p, all)) front.insert(p.pointId);
        const std::vector<MeasuredPoint> picked = bestPoints(all, 5);
        ASSERT_EQ(picked.size(), 5u);
        for (const MeasuredPoint& p : picked) best.insert(p.pointId);
        ASSERT_EQ(best.size(), 5u);
        size_t fromFront = 0;
        for (const std::string& id : best) fromFront += front.contains(id);
        EXPECT_EQ(fromFront, std::min<size_t>(5, front.size()));
        for (size_t i = 1; i < picked.size(); ++i) EXPECT_LE(picked[i - 1].frameMs, picked[i].frameMs);
        const auto fastest = std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.frameMs < b.frameMs; });
        const auto exactest = std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.error < b.error; });
        EXPECT_TRUE(best.contains(fastest->pointId));
        EXPECT_TRUE(best.contains(exactest->pointId));
    }
    EXPECT_EQ(bestPoints(randomPoints(1, 3), 5).size(), 3u);
    EXPECT_TRUE(bestPoints({}, 5).empty());
}

TEST(BestPoints, AreReadFromARunWithoutItsBaselines) {
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
    const std::string table = bestPointsTable(points, plan);
    EXPECT_NE(table.find("uniform"), std::string::npos);
    EXPECT_NE(table.find("size=256"), std::string::npos);
    EXPECT_EQ(table.find("unshadowed "), table.find("unshadowed  textures"));  // only in the heading
}

}  // namespace
}  // namespace dapple::bench
