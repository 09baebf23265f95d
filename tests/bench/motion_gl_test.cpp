// Figures of a moving sun, against runs in which it stands still at each place of its path.
#include "bench/plan.h"
#include "bench/stage.h"
#include "base/error.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

namespace dapple::bench {
namespace {

PointSpec spec(const std::string& technique, shadow::Settings axes, const std::optional<MotionPath>& path) {
    PointSpec s;
    s.scene = "forest-small";
    s.technique = technique;
    if (shadow::technique(technique).defaults.contains("size")) axes.try_emplace("size", "256");
    s.settings = shadow::resolve(shadow::technique(technique), axes);
    s.view = "above";
    s.width = 120, s.height = 90;
    s.path = path;
    return s;
}

std::map<std::string, Figure> byMetric(const std::vector<Figure>& figures) {
    std::map<std::string, Figure> found;
    for (const Figure& f : figures)
        if (f.pass.empty()) found[f.metric] = f;
    return found;
}

TEST(Motion, ErrorsAreTheMeansOfSunsThatStandStill) {
    for (const bool azimuth : {false, true})
        for (const auto& [technique, update] : {std::pair("uniform", ""), {"instanced", "regenerate"}, {"instanced", "cached"}}) {
            const bool instanced = *update != 0;
            if (instanced && azimuth) continue;  // fresh maps are laid out at other rotations against the sun
            SCOPED_TRACE(fmt::format("{} {} {}", technique, update, azimuth));
            const MotionPath path{azimuth ? 3.0 : 0.0, azimuth ? 0.0 : -1.5, 4};
            const shadow::Settings axes = instanced ? shadow::Settings{{"update", update}} : shadow::Settings{};
            const auto moving = byMetric(workbench().open(spec(technique, axes, path))->errors());
            double sum = 0, most = 0;
            for (int frame = 1; frame < path.frames; ++frame) {
                PointSpec still = spec(technique, axes, std::nullopt);
                still.sceneSettings = {fmt::format("sun.azimuth={}", 135 + frame * path.azimuthPerFrame), fmt::format("sun.elevation={}", 45 + frame * path.elevationPerFrame)};
                const double error = byMetric(workbench().open(still)->errors()).at("error").value.value();
                sum += error;
                most = std::max(most, error);
            }
            EXPECT_NEAR(moving.at("error").value.value(), sum / 3, 1e-4);
            EXPECT_EQ(moving.at("error").spread.value().n, 3u);
            EXPECT_NEAR(moving.at("error").spread->max, most, 1e-4);
            if (instanced) {
                EXPECT_EQ(moving.at("map_age_worst").value, 0);
                EXPECT_EQ(moving.at("map_lag_worst").value, 0);
            }
        }
}

TEST(Motion, AWalkIsTheMeanOfItsPlacesAndComparesWhatStaysInSight) {
    const auto walk = [](double metres, int frames) { return MotionPath{.frames = frames, .metresPerFrame = metres, .heading = 30, .turnPerFrame = metres}; };
    for (const char* technique : {"focused", "cascaded", "instanced"}) {
        SCOPED_TRACE(technique);
        const double one = byMetric(workbench().open(spec(technique, {}, walk(0.4, 2)))->errors()).at("error").value.value();
        const double two = byMetric(workbench().open(spec(technique, {}, walk(0.8, 2)))->errors()).at("error").value.value();
        const auto both = byMetric(workbench().open(spec(technique, {}, walk(0.4, 3)))->errors());
        EXPECT_NE(one, two);
        EXPECT_NEAR(both.at("error").value.value(), (one + two) / 2, 1e-9);
        EXPECT_EQ(both.at("error").spread->max, std::max(one, two));
        // The points compared are half a pixel apart at most, and the sensitivity is what half a pixel changes.
        EXPECT_LT(both.at("reference_flips").value.value(), 1.5 * both.at("half_pixel_sensitivity").value.value());
        EXPECT_GT(both.at("reference_flips").value.value(), 0);
    }
    const auto lit = byMetric(workbench().open(spec("unshadowed", {}, walk(0.4, 3)))->errors());
    EXPECT_EQ(lit.at("flips").value, 0);
}

// Cars drive on, out of sight and in it, and so do their shadows in the truth.
TEST(Motion, ErrorsAreTheMeansOfScenesThatStandStill) {
    const auto at = [](int seconds) {
        PointSpec s = spec("uniform", {{"size", "2048"}}, std::nullopt);
        s.scene = "city-vienna";
        s.sceneSettings = {"scale=0.03", "city.traffic=60", fmt::format("time={}", seconds)};
        return s;
    };
    PointSpec driving = at(3);
    driving.view = workbench().sceneFacts(driving.scene, driving.sceneSettings, {}).views.front();
    driving.path = MotionPath{.frames = 4, .secondsPerFrame = 2};
    const auto moving = byMetric(workbench().open(driving)->errors());
    std::map<std::string, double> sums;
    for (int frame = 1; frame < 4; ++frame) {
        PointSpec still = at(3 + 2 * frame);
        still.view = driving.view;
        for (const auto& [metric, figure] : byMetric(workbench().open(still)->errors()))
            if (figure.value) sums[metric] += *figure.value / 3;
    }
    for (const char* metric : {"error", "false_shadow", "false_light", "shadowed", "valid"}) EXPECT_NEAR(moving.at(metric).value.value(), sums.at(metric), 1e-6) << metric;
    EXPECT_GT(moving.at("reference_flips").value.value(), 0.001);
    // Who asks for no motion finds the scene as it was loaded.
    PointSpec before = at(3);
    before.view = driving.view;
    const auto again = byMetric(workbench().open(before)->errors());
    workbench().releaseScene("city-vienna");
    EXPECT_EQ(again.at("shadowed").value, byMetric(workbench().open(before)->errors()).at("shadowed").value);
}

TEST(Motion, WhatCastsNoShadowLacksAllFlipsOfTheTruth) {
    const auto figures = byMetric(workbench().open(spec("unshadowed", {}, MotionPath{1, -0.5, 4}))->errors());
    EXPECT_EQ(figures.at("flips").value, 0);
    EXPECT_GT(figures.at("reference_flips").value.value(), 0.01);
    EXPECT_EQ(figures.at("excess_flips").value.value(), -figures.at("reference_flips").value.value());
}

TEST(Motion, BudgetsAndCriteriaShowInTexelsAndLags) {
    const MotionPath path{0, -0.05, 9};
    std::map<std::string, double> texels, lag;
    for (const char* update : {"regenerate", "criterion", "round-robin"}) {
        const auto point = workbench().open(spec("instanced", {{"update", update}}, path));
        const auto counters = byMetric(point->counters());
        texels[update] = counters.at("texels_written").value.value() / (256 * 256);
        const auto errors = byMetric(point->errors());
        lag[update] = errors.at("map_lag_worst").spread.value().max;
        EXPECT_EQ(byMetric(point->errors()).at("excess_flips").value, errors.at("excess_flips").value) << "each evaluation starts anew";
    }
    EXPECT_EQ(texels["regenerate"], 20);  // a ring of 12 for 16 oaks, a map for each of 8 firs
    EXPECT_EQ(texels["round-robin"], 4);
    EXPECT_LT(texels["criterion"], 12);
    EXPECT_GT(texels["criterion"], 0);
    EXPECT_EQ(lag["regenerate"], 0);
    EXPECT_GT(lag["round-robin"], 4 * 0.05 - 1e-6);  // five frames a round
    EXPECT_GT(lag["criterion"], 0.04);
}

TEST(Motion, TimedFramesHaveTheSamePassesThroughout) {
    for (const char* update : {"cached", "criterion", "round-robin", "regenerate"}) {
        const auto point = workbench().open(spec("instanced", {{"update", update}}, MotionPath{0, -0.02, 5}));
        point->beginBlocks();
        for (int i = 0; i < 12; ++i) point->submitFrame(true);
        for (const measure::FrameTimes& times : point->drain()) EXPECT_EQ(times.passMs.size(), point->passNames().size()) << update;
        EXPECT_NE(std::ranges::find(point->passNames(), "maps"), point->passNames().end()) << update;
    }
}

TEST(Motion, APathIntoTheNightIsRefused) {
    Sweep sweep = parseSweep("question = \"?\"\nscenes = [\"forest-small\"]\n[motion]\nsun_elevation_per_frame = -5\nframes = 12\n[[technique]]\nname = \"uniform\"\n", "dusk.toml");
    try {
        makePlan(sweep, workbench());
        FAIL();
    } catch (const base::UsageError& e) {
        EXPECT_NE(std::string(e.what()).find("-10 degrees"), std::string::npos) << e.what();
    }
    sweep.path->frames = 9;
    EXPECT_NE(makePlan(sweep, workbench()).points.at(0).id, pointId(spec("uniform", {}, std::nullopt), 0));
}

}  // namespace
}  // namespace dapple::bench
