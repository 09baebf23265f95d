// The far field of instanced shadow maps: both ends of its distance are techniques of their own, bit for bit; between them no
// caster is lost; its prediction against brute force.
#include "base/random.h"
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/instanced/far_field.h"
#include "shadow/renderer.h"
#include "truth/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::shadow {
namespace {

/// Whether the ray t·d, t ≥ near, meets the box of half size h about c swept from 0 to `length` along l: the polygon of all
/// (t, s) for which t·d lies in the box moved by s·l, cut by one half-plane after another, is not empty.
bool meetsSwept(const glm::dvec3& d, double near, const glm::dvec3& c, const glm::dvec3& h, const glm::dvec3& l, double length) {
    std::vector<glm::dvec2> polygon{{near, 0}, {1e5, 0}, {1e5, length}, {near, length}};
    for (int k = 0; k < 3; ++k)
        for (const double sign : {1.0, -1.0}) {
            std::vector<glm::dvec2> kept;
            const auto inside = [&](const glm::dvec2& p) { return h[k] - sign * (p.x * d[k] - p.y * l[k] - c[k]); };
            for (size_t i = 0; i < polygon.size(); ++i) {
                const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
                const double da = inside(a), db = inside(b);
                if (da >= 0) kept.push_back(a);
                if ((da >= 0) != (db >= 0)) kept.push_back(a + (b - a) * (da / (da - db)));
            }
            polygon = kept;
        }
    return !polygon.empty();
}

TEST(FarFieldPrediction, PixelsOfAVolumeAreThoseWhoseRaysMeetIt) {
    const frame::Camera camera({"v", {0, 0, 0}, glm::normalize(glm::dvec3(1, 0.3, -0.2)), {0, 0, 1}, 70, 0.5, 1e4}, 120, 90);
    base::Random random(7, 0, 0);
    size_t partly = 0, none = 0;
    for (int trial = 0; trial < 60; ++trial) {
        const auto between = [&](double lo, double hi) { return lo + (hi - lo) * double(random.next()); };
        // Before the eye, beside and behind it, and some that hold it.
        const glm::dvec3 centre(between(-20, 60), between(-30, 30), between(-10, 10)), half(between(0.5, 6), between(0.5, 6), between(0.5, 6));
        const double heading = between(0, 6.28), elevation = between(0.02, 1.5), length = between(1, 80);
        const glm::dvec3 light(std::cos(elevation) * std::cos(heading), std::cos(elevation) * std::sin(heading), -std::sin(elevation));
        std::array<glm::dvec3, 8> corners;
        for (int k = 0; k < 8; ++k) corners[size_t(k)] = centre + half * glm::dvec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
        double expected = 0;
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                const glm::dvec3 d = camera.forward + camera.right * camera.tanX * (2 * (x + 0.5) / camera.width - 1) + camera.up * camera.tanY * (2 * (y + 0.5) / camera.height - 1);
                expected += meetsSwept(d, camera.near, centre, half, light, length);
            }
        EXPECT_NEAR(volumePixels(camera, corners, light, length), expected, 0.01 * expected + 40) << trial;
        partly += expected > 0 && expected < 120 * 90;
        none += expected == 0;
    }
    EXPECT_GT(partly, 20u);
    EXPECT_GT(none, 5u);
}

TEST(FarFieldPrediction, TheCutIsTheCheapestOfAll) {
    base::Random random(3, 0, 0);
    size_t within = 0;
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<FarCost> costs(size_t(trial % 12));
        for (FarCost& c : costs) c = {100 * double(random.next()), std::floor(100 * double(random.next()))};
        const double perTriangle = 2 * double(random.next()), fixed = 100 * double(random.next());
        const auto total = [&](size_t near) {
            double sum = near < costs.size() ? fixed : 0;
            for (size_t i = 0; i < costs.size(); ++i) sum += i < near ? costs[i].fragments : perTriangle * costs[i].triangles;
            return sum;
        };
        const size_t near = nearestAsVolumes(costs, perTriangle, fixed);
        ASSERT_LE(near, costs.size());
        for (size_t k = 0; k <= costs.size(); ++k) EXPECT_LE(total(near), total(k) + 1e-9);
        double least = 1e300, chosen = 0;
        bool whole = true;
        const std::vector<bool> volumes = cheaperAsVolumes(costs, perTriangle, fixed);
        ASSERT_EQ(volumes.size(), costs.size());
        for (size_t i = 0; i < costs.size(); ++i) chosen += volumes[i] ? costs[i].fragments : perTriangle * costs[i].triangles, whole &= volumes[i];
        for (size_t subset = 0; subset < size_t(1) << costs.size(); ++subset) {
            double sum = subset + 1 == size_t(1) << costs.size() ? 0 : fixed;
            for (size_t i = 0; i < costs.size(); ++i) sum += subset >> i & 1 ? costs[i].fragments : perTriangle * costs[i].triangles;
            least = std::min(least, sum);
        }
        EXPECT_NEAR(chosen + (whole ? 0 : fixed), least, 1e-9);
        within += near > 0 && near < costs.size();
    }
    EXPECT_GT(within, 25u);
}

class FarFieldImage : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);
    frame::PassObserver silent_;

    struct Image {
        std::vector<float> visibility;
        std::vector<uint8_t> validity;
        std::vector<frame::Pass> passes;
        bool runs(const std::string& pass) const {
            return std::ranges::any_of(passes, [&](const frame::Pass& p) { return p.name == pass && p.leftOut.empty(); });
        }
    };
    Image render(frame::Frame& frame, const char* name, const Settings& axes) {
        Renderer renderer(frame, technique(name), resolve(technique(name), axes));
        for (int i = 0; i < 2; ++i) renderer.render(silent_);
        return {renderer.visibility(), frame.readValidity(), renderer.passes()};
    }
};

TEST_F(FarFieldImage, AtBothEndsItIsInstancedAloneAndTheMapsAlone) {
    for (const char* sun : {"sun.elevation=8", "sun.elevation=50"}) {
        const scenegen::Scene scene = scenegen::loadScene("forest-small", {sun});
        const gpuscene::GpuScene gpu(scene);
        for (const char* view : {"walk1", "above"}) {
            frame::Frame frame(gpu, scene.views[scene.viewIndex(view)], 160, 120);
            for (const Settings& look : {Settings{}, {{"filter", "pcf3"}, {"mode", "nearest"}}, {{"accumulate", "multiply"}, {"apply", "zfail"}}, {{"cull", "mask"}}, {{"resolution", "estimate"}}}) {
                const auto with = [&](const char* axis, const char* value) {
                    Settings s = look;
                    s[axis] = value;
                    return s;
                };
                const Image alone = render(frame, "instanced", look), infinite = render(frame, "instanced", with("far-field", "1000000")), zero = render(frame, "instanced", with("far-field", "0"));
                EXPECT_EQ(alone.visibility, infinite.visibility);
                EXPECT_EQ(alone.validity, infinite.validity);
                EXPECT_FALSE(infinite.runs("far.map0") || infinite.runs("far"));
                EXPECT_TRUE(zero.runs("far.resolve"));
                Settings same;
                if (look.contains("filter")) same["filter"] = look.at("filter");
                const Image map = render(frame, "cascaded", same);
                EXPECT_EQ(zero.visibility, map.visibility);
                EXPECT_EQ(zero.validity, map.validity);
                EXPECT_NE(alone.visibility, map.visibility);
            }
        }
    }
}

// Wherever the two meet, each caster is in one of them: nothing is darker than in instanced shadows alone or maps alone, and what
// is dark in both stays dark, but for pixels that different casters darken in the two. The error is not above that of the worse by
// more than half a percent of the pixels.
TEST_F(FarFieldImage, NoCasterIsLostBetween) {
    for (const char* sun : {"sun.elevation=8", "sun.elevation=40"}) {
        const scenegen::Scene scene = scenegen::loadScene("forest-small", {sun});
        const gpuscene::GpuScene gpu(scene);
        frame::Frame frame(gpu, scene.views[scene.viewIndex("above")], 240, 180);
        const Image instanced = render(frame, "instanced", {}), map = render(frame, "cascaded", {});
        const truth::Reference truth = truth::Tracer(scene).trace(frame.readReceivers(), frame.camera().eye, frame.light());
        const auto error = [&](const Image& image) { return truth::measureError(truth, image.visibility).error; };
        size_t mixed = 0;
        for (const Settings& choice : {Settings{{"far-field", "20"}}, {{"far-field", "35"}}, {{"far-field", "50"}}, {{"far-field", "65"}}, {{"far-field", "each"}, {"far-cost", "10"}},
                                       {{"far-field", "each"}, {"far-cost", "40"}}, {{"far-field", "each"}, {"far-cost", "160"}}}) {
            SCOPED_TRACE(std::string(sun) + " " + choice.at("far-field"));
            const Image both = render(frame, "instanced", choice);
            EXPECT_LE(error(both), std::max(error(instanced), error(map)) + 0.005);
            size_t darker = 0, darkInEach = 0, lost = 0;
            for (size_t i = 0; i < both.visibility.size(); ++i) {
                darker += both.visibility[i] < std::min(instanced.visibility[i], map.visibility[i]);
                const bool dark = both.validity[i] && instanced.visibility[i] == 0 && map.visibility[i] == 0;
                darkInEach += dark;
                lost += dark && both.visibility[i] > 0;
            }
            EXPECT_EQ(darker, 0u);
            EXPECT_GT(darkInEach, 3000u);
            EXPECT_LE(lost, darkInEach / 400);
            if (both.visibility != instanced.visibility && both.visibility != map.visibility) ++mixed;
        }
        EXPECT_GE(mixed, 3u);
    }
}

TEST_F(FarFieldImage, TheCostsThatItIsToldDecide) {
    const scenegen::Scene scene = scenegen::loadScene("forest-small", {"sun.elevation=8"});
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[scene.viewIndex("above")], 160, 120);
    const Image alone = render(frame, "instanced", {}), map = render(frame, "cascaded", {});
    for (const char* choice : {"auto", "each"}) {
        const Image dear = render(frame, "instanced", {{"far-field", choice}, {"far-cost", "1000000"}});
        EXPECT_FALSE(dear.runs("far"));
        EXPECT_EQ(dear.visibility, alone.visibility);
        const Image free = render(frame, "instanced", {{"far-field", choice}, {"far-cost", "0"}});
        EXPECT_TRUE(free.runs("far"));
        EXPECT_EQ(free.visibility, map.visibility);
    }
}

TEST(FarFieldAxis, TakesWordsAndMetresAndRefusesWhatItCannotDo) {
    const Axis& far = axis("far-field");
    EXPECT_EQ(far.canonical("auto"), "auto");
    EXPECT_EQ(far.canonical("0120"), "120");
    EXPECT_ANY_THROW(far.canonical("-1"));
    EXPECT_ANY_THROW(far.canonical("far"));
    const TechniqueInfo& info = technique("instanced");
    scenegen::Facts facts;
    for (const Settings& refused : {Settings{{"apply", "tiled"}}, {{"apply", "all"}}, {{"accumulate", "stencil"}}}) {
        Settings axes = refused;
        axes["far-field"] = "auto";
        EXPECT_TRUE(pruneReason(info, resolve(info, axes), facts, {}));
    }
    EXPECT_TRUE(pruneReason(info, resolve(info, {{"far-field", "100"}, {"far-cost", "3"}}), facts, {}));
    EXPECT_FALSE(pruneReason(info, resolve(info, {{"far-field", "auto"}, {"far-cost", "3"}}), facts, {}));
    facts.translucent = true;
    EXPECT_TRUE(pruneReason(info, resolve(info, {{"far-field", "auto"}, {"accumulate", "multiply"}}), facts, {}));
}

}  // namespace
}  // namespace dapple::shadow
