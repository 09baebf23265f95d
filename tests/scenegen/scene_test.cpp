#include "base/error.h"
#include "scenegen/library.h"
#include "scenegen/scene.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

using namespace dapple::scenegen;

TEST(Motion, drivesAtItsSpeedAndBeginsAgain) {
    const Motion m{0, {10, 0, 1}, {10, 40, 1}, 8, 6};  // 40 m at 8 m/s, from 6 m on: a lap takes 5 s
    EXPECT_EQ(m.at(0), glm::vec3(10, 6, 1));
    EXPECT_EQ(m.at(2), glm::vec3(10, 22, 1));
    EXPECT_EQ(m.at(4.5), glm::vec3(10, 2, 1)) << "6 + 36 m is 2 m into the second lap";
    EXPECT_EQ(m.at(5), m.at(0));
    EXPECT_EQ(m.at(-1), glm::vec3(10, 38, 1)) << "before time 0 it was on the lap before";
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
