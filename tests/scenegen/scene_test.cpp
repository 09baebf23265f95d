#include "base/error.h"
#include "scenegen/library.h"
#include "scenegen/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

using namespace dapple::scenegen;

TEST(Motion, drivesThereAndBackByHalfCircles) {
    const double pi = std::numbers::pi;
    const Motion m{0, {10, 0, 1}, {10, 40, 1}, 8, 6, 6, 3};  // northwards; back 6 m to the left
    EXPECT_NEAR(m.lap(), 2 * (40 + 3 * pi), 1e-6);
    const auto expect = [&](double seconds, const glm::dvec2& place, double yaw) {
        const Motion::Pose p = m.at(seconds);
        EXPECT_NEAR(glm::distance(glm::dvec3(p.translation), glm::dvec3(place, 1)), 0, 1e-5) << seconds;
        EXPECT_NEAR(std::cos(double(p.yaw) - yaw), 1, 1e-9) << seconds;
    };
    expect(0, {10, 6}, pi / 2);
    expect(2, {10, 22}, pi / 2);
    expect((34 + 1.5 * pi) / 8, {7, 43}, pi);               // half-way round the turn, heading west
    expect((34 + 3 * pi + 10) / 8, {4, 30}, -pi / 2);       // 10 m into the way back
    expect((74 + 4.5 * pi) / 8, {7, -3}, 0);
    expect(m.lap() / 8, {10, 6}, pi / 2);
    expect(-1, {10 - 3 + 3 * std::cos(2 / 3.0), -3 * std::sin(2 / 3.0)}, pi / 2 - 2 / 3.0);  // before time 0 it was on the lap before: 2 m before `from`
}

/// Of turns of every width: the way is as long as its steps, and the heading is where it goes.
TEST(Motion, isContinuous) {
    for (const auto& [across, radius] : {std::pair(4.0f, 2.0f), {3.9f, 2.9f}, {3.9f, 4.8f}, {10.7f, 5.35f}}) {
        const Motion m{0, {3, -2, 0}, {-40, 17, 0}, 10, 0, across, radius};
        double way = 0;
        for (int i = 0; i < 20'000; ++i) {
            const auto pose = [&](int k) { return m.at(k * m.lap() / 10 / 10'000); };
            const Motion::Pose a = pose(i), b = pose(i + 1);
            const glm::dvec3 step = glm::dvec3(b.translation) - glm::dvec3(a.translation);
            const double wanted = m.lap() / 10'000, yaw = 0.5 * (double(a.yaw) + double(b.yaw));
            ASSERT_NEAR(glm::length(step), wanted, 2e-5);
            ASSERT_GT(std::cos(double(a.yaw) - double(b.yaw)), std::cos(1.1 * wanted / double(radius) + 1e-4));
            ASSERT_GT(std::abs(std::cos(yaw) * step.x + std::sin(yaw) * step.y), 0.999 * wanted);
            way += glm::length(step);
        }
        EXPECT_NEAR(way, 2 * m.lap(), 0.02);
    }
}

TEST(Motion, movesItsInstanceAndNothingElse) {
    Scene scene = loadScene("forest-small");
    const std::vector<Instance> before = scene.instances;
    EXPECT_FALSE(scene.facts().moving);
    scene.motions.push_back({2, {0, 0, 0}, {100, 0, 0}, 1, 0});
    validate(scene);
    EXPECT_TRUE(scene.facts().moving);
    scene.moveTo(25);
    for (size_t i = 0; i < before.size(); ++i)
        EXPECT_EQ(scene.instances[i].translation, i == 2 ? glm::vec3(25, 0, 0) : before[i].translation);
}

TEST(Scene, factsCountLightsAndOnlyWhatMovesIsMoving) {
    Scene scene = loadScene("box");
    EXPECT_EQ(scene.facts().lights, 0u);
    const uint64_t plain = scene.contentHash();
    scene.lights.resize(3);
    scene.motions.push_back({0, {0, 0, 0}, {1, 0, 0}, 0, 0});
    EXPECT_EQ(scene.facts().lights, 3u);
    EXPECT_FALSE(scene.facts().moving) << "a car at speed 0 is parked";
    EXPECT_NE(scene.contentHash(), plain);
}

TEST(Scene, badLightsAndMotionsAreRefusedByName) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::pair<const char*, std::function<void(Scene&)>> cases[] = {
        {"local light 0 is not finite", [&](Scene& s) { s.lights.push_back({.position = {nan, 0, 0}}); }},
        {"unit length", [](Scene& s) { s.lights.push_back({.direction = {0, 0, -2}}); }},
        {"range 0", [](Scene& s) { s.lights.push_back({.range = 0}); }},
        {"inner < outer", [](Scene& s) { s.lights.push_back({.innerAngle = 1, .outerAngle = 1}); }},
        {"does not exist", [](Scene& s) { s.motions.push_back({99, {0, 0, 0}, {1, 0, 0}, 1, 0}); }},
        {"goes nowhere", [](Scene& s) { s.motions.push_back({0, {1, 0, 0}, {1, 0, 0}, 1, 0}); }},
        {"turns by 4 m", [](Scene& s) { s.motions.push_back({0, {0, 0, 0}, {1, 0, 0}, 1, 0, 4, 1.9f}); }},
        {"motion 0 is not finite", [&](Scene& s) { s.motions.push_back({0, {0, 0, 0}, {1, 0, 0}, nan, 0}); }},
    };
    for (const auto& [message, spoil] : cases) {
        Scene scene = loadScene("box");
        spoil(scene);
        try {
            validate(scene);
            ADD_FAILURE() << "accepted: " << message;
        } catch (const dapple::base::UsageError& error) {
            EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
        }
    }
}
