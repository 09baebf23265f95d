// When maps are due, against the motion of shadows computed point by point.
#include "shadow/instanced/update_policy.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <set>

namespace dapple::shadow {
namespace {

Settings settings(const char* update, const char* budget = "4") { return {{"update", update}, {"budget", budget}}; }

/// Where the top of an object of that height, turned by `yaw` with an offset from its axis of 0, darkens the ground.
glm::dvec2 tip(double height, double heading, double elevation) {
    const glm::dvec3 light = SunAngles{heading, elevation}.light();
    return glm::dvec2(light) * (height / -light.z);
}

TEST(SunAngles, AreThoseOfTheLightAndItsBasisTurnsWithTheHeading) {
    base::Random random(5, 0, 0);
    for (int trial = 0; trial < 200; ++trial) {
        const double heading = double(random.next(-3.1f, 3.1f)), elevation = double(random.next(0.01f, 1.5f)), turn = double(random.next(-3, 3));
        const SunAngles back = sunAngles(SunAngles{heading, elevation}.light());
        EXPECT_NEAR(back.heading, heading, 1e-9);
        EXPECT_NEAR(back.elevation, elevation, 1e-12);
        const LightBasis a = SunAngles{heading, elevation}.basis(), b = SunAngles{heading + turn, elevation}.basis();
        EXPECT_NEAR(glm::length(glm::cross(a.u, a.v) + a.l), 0, 1e-12);  // as lightBasis has it: u = l × v
        const glm::dvec3 p(random.next(-9, 9), random.next(-9, 9), random.next(-9, 9));
        const glm::dvec3 turned(std::cos(turn) * p.x - std::sin(turn) * p.y, std::sin(turn) * p.x + std::cos(turn) * p.y, p.z);
        EXPECT_NEAR(glm::distance(a.toLight(p), b.toLight(turned)), 0, 1e-12);
        const LightBasis fixed = lightBasis(a.l, {0, 0, 1});
        if (elevation < 1.4) {
            EXPECT_NEAR(glm::distance(a.u, fixed.u) + glm::distance(a.v, fixed.v), 0, 1e-9);
        }
    }
}

TEST(UpdatePolicy, CriterionIsDueWhenTheShadowsTipHasMovedByATexel) {
    base::Random random(6, 0, 0);
    for (int trial = 0; trial < 300; ++trial) {
        const double e = double(random.next(0.1f, 1.3f)), h = double(random.next(1, 30)), texel = double(random.next(0.005f, 0.05f));
        for (const bool azimuth : {false, true})
            for (const double share : {0.98, 1.02}) {
                UpdatePolicy policy(settings("criterion"));
                UpdatePolicy::Map map{{0.3, e}, texel, h, 0, false};
                policy.renderAll({&map, 1});
                // A step that moves the tip by that share of a texel, found by bisection, not by the formula.
                double lo = 0, hi = 0.5;
                const auto moved = [&](double step) { return glm::distance(tip(h, 0, e), azimuth ? tip(h, step, e) : tip(h, 0, e - step)); };
                for (int i = 0; i < 60; ++i) (moved((lo + hi) / 2) < share * texel ? lo : hi) = (lo + hi) / 2;
                if (azimuth) map.wanted.yaw += lo;
                else map.wanted.elevation -= lo;
                // The criterion is of first order: at the new elevation sin² e is another.
                if (!azimuth && texel / h > 1e-3) continue;
                EXPECT_EQ(!policy.due({&map, 1}, {}).empty(), share > 1) << trial << " " << azimuth << " " << share;
            }
    }
    // The sheet's own numbers: 2 cm, 20 m, 30 degrees: 0.014 and 0.033 degrees.
    for (const auto& [elevationStep, yawStep, isDue] : {std::tuple(0.0141, 0.0, false), {0.0145, 0.0, true}, {0.0, 0.0329, false}, {0.0, 0.0332, true}}) {
        UpdatePolicy policy(settings("criterion"));
        const double e = glm::radians(30.0);
        UpdatePolicy::Map map{{0, e + glm::radians(elevationStep)}, 0.02, 20, 0, false};
        policy.renderAll({&map, 1});
        map.wanted = {glm::radians(yawStep), e};
        EXPECT_EQ(!policy.due({&map, 1}, {}).empty(), isDue) << elevationStep << " " << yawStep;
    }
}

TEST(UpdatePolicy, RoundRobinKeepsToItsBudgetStartsWithTheMostUsedAndStarvesNone) {
    std::vector<UpdatePolicy::Map> maps;
    for (uint32_t i = 0; i < 10; ++i) maps.push_back({{0, 1}, 0.01, 10, i / 2, false});
    const std::vector<uint32_t> uses{1, 9, 3, 0, 5};
    UpdatePolicy policy(settings("round-robin", "3"));
    policy.renderAll(maps);
    EXPECT_TRUE(policy.due(maps, uses).empty());
    std::vector<int> last(10, 0);
    std::vector<int> firstRound;
    for (int frame = 1; frame <= 40; ++frame) {
        for (auto& map : maps) map.wanted.elevation = 1 - 0.001 * frame;
        const std::vector<int> due = policy.due(maps, uses);
        EXPECT_EQ(due.size(), 3u);
        EXPECT_EQ(std::set<int>(due.begin(), due.end()).size(), 3u);
        if (frame <= 2) firstRound.insert(firstRound.end(), due.begin(), due.end());
        for (const int i : due) last[size_t(i)] = frame;
        double worst = 0, degrees = 0;
        for (const int f : last) {
            worst = std::max(worst, double(frame - f));
            degrees = std::max(degrees, glm::degrees(0.001 * (frame - f)));
        }
        EXPECT_LE(worst, 5);  // ⌈10 / 3⌉ frames, and one more for those that a new round found just rendered
        const Staleness s = policy.staleness(maps, std::vector<bool>(10, true));
        EXPECT_EQ(s.worstFrames, worst);
        EXPECT_NEAR(s.worstDegrees, degrees, 1e-9);
        EXPECT_NEAR(s.meanFrames * 10, std::accumulate(last.begin(), last.end(), 0.0, [&](double sum, int f) { return sum + frame - f; }), 1e-9);
    }
    EXPECT_EQ(std::set<int>(firstRound.begin(), firstRound.end()), (std::set<int>{2, 3, 8, 9, 4, 5}));  // types 1, 4, 2
}

TEST(UpdatePolicy, EachRendersWhatItSays) {
    std::vector<UpdatePolicy::Map> maps{{{0, 1}, 0.01, 10, 0, false}, {{0, 1}, 0.01, 10, 1, true}};
    const auto after = [&](const char* update, double turn, double rise) {
        UpdatePolicy policy(settings(update));
        std::vector<UpdatePolicy::Map> now = maps;
        policy.renderAll(now);
        for (auto& map : now) map.wanted = {map.wanted.yaw + turn, map.wanted.elevation + rise};
        return policy.due(now, {});
    };
    using Maps = std::vector<int>;
    EXPECT_EQ(after("cached", 0, 0), Maps{});
    EXPECT_EQ(after("moving", 0, 0), Maps{1});
    EXPECT_EQ(after("criterion", 0, 0), Maps{1});
    EXPECT_EQ(after("round-robin", 0, 0), Maps{1});
    EXPECT_EQ(after("regenerate", 0, 0), (Maps{0, 1}));
    for (const char* update : {"cached", "moving", "regenerate", "round-robin"}) EXPECT_EQ(after(update, 0, 1e-5), (Maps{0, 1})) << update;
    EXPECT_EQ(after("criterion", 0, 1e-5), Maps{1});
    EXPECT_EQ(after("cached", 2 * std::numbers::pi, 0), Maps{});  // a whole turn is none
    // What is forgotten is due whatever the policy, and beyond a budget.
    for (const char* update : {"cached", "criterion", "round-robin"}) {
        UpdatePolicy policy(settings(update, "1"));
        policy.renderAll(maps);
        policy.forget(0);
        EXPECT_TRUE(policy.outdated(maps));
        EXPECT_EQ(policy.due(maps, {}).front(), 0) << update;
    }
}

}  // namespace
}  // namespace dapple::shadow
