// Instanced maps under a sun and objects that move, against frames that never saw another sun, and against the whole world
// turned instead.
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/renderer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::shadow {
namespace {

constexpr int kWidth = 160, kHeight = 120;

class MovingSun : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);
    scenegen::Scene scene_ = scenegen::loadScene("forest-small");
    gpuscene::GpuScene gpu_{scene_};
    frame::PassObserver silent_;

    static Settings with(Settings axes) {
        axes.try_emplace("size", "256");
        return resolve(technique("instanced"), axes);
    }
    std::vector<float> rendered(Renderer& renderer) {
        renderer.replan();
        renderer.render(silent_);
        return renderer.visibility();
    }
    /// By frame and renderer that begin under this sun.
    std::vector<float> fresh(const gpuscene::GpuScene& gpu, const scenegen::View& view, const scenegen::Sun& sun, const Settings& settings) {
        frame::Frame frame(gpu, view, kWidth, kHeight);
        frame.setSun(sun);
        Renderer renderer(frame, technique("instanced"), settings);
        return rendered(renderer);
    }
    static size_t texelsWritten(Renderer& renderer) {
        struct Count : frame::PassObserver {
            size_t texels = 0;
            void endPass(const frame::Pass&, const measure::Ledger& ledger) override { texels += ledger.texelsWritten; }
        } count;
        renderer.replan();
        renderer.render(count);
        return count.texels;
    }
    static size_t different(const std::vector<float>& a, const std::vector<float>& b) {
        size_t n = 0;
        for (size_t i = 0; i < a.size(); ++i) n += a[i] != b[i];
        return n;
    }
};

scenegen::Scene turned(scenegen::Scene scene, double radians) {
    const auto turn = [&](const glm::dvec3& p) {
        return glm::dvec3(std::cos(radians) * p.x - std::sin(radians) * p.y, std::sin(radians) * p.x + std::cos(radians) * p.y, p.z);
    };
    for (scenegen::Instance& i : scene.instances) {
        i.translation = glm::vec3(turn(i.translation));
        i.yaw = float(double(i.yaw) + radians);
    }
    for (scenegen::View& v : scene.views) v = {v.name, turn(v.eye), turn(v.forward), turn(v.up), v.fovY, v.near, v.far};
    return scene;
}

// A sun that has only changed its azimuth re-renders no map, and the look-up's rotation makes up for it: the same pixels as
// the world turned the other way under the old sun, with maps of its own. Six maps are fewer than either species has yaws.
TEST_F(MovingSun, AzimuthTurnsTheLookUpAndNotTheMaps) {
    const scenegen::View& view = scene_.views[scene_.viewIndex("above")];
    for (const double degrees : {20.0, -140.0}) {
        const scenegen::Scene other = turned(scene_, glm::radians(degrees));  // azimuths run clockwise, rotations against it
        const gpuscene::GpuScene otherGpu(other);
        scenegen::Sun later = scene_.sun;
        later.azimuth += degrees;
        for (const Settings& ways : {Settings{{"mode", "nearest"}, {"sample-frame", "A"}}, Settings{{"mode", "nearest"}, {"sample-frame", "B"}},
                                     Settings{{"mode", "depth"}, {"sample-frame", "EB"}}, Settings{{"mode", "blend"}, {"sample-frame", "E"}}}) {
            Settings axes = ways;
            axes["rotations"] = "6";
            SCOPED_TRACE(axes.at("mode") + axes.at("sample-frame") + std::to_string(degrees));
            frame::Frame frame(gpu_, view, kWidth, kHeight);
            Renderer renderer(frame, technique("instanced"), with(axes));
            const std::vector<float> before = rendered(renderer);
            frame.setSun(later);
            EXPECT_EQ(texelsWritten(renderer), 0u);
            const std::vector<float> after = renderer.visibility();
            const std::vector<float> oracle = fresh(otherGpu, other.views[other.viewIndex("above")], scene_.sun, with(axes));
            // The turned world rounds otherwise: single pixels of twigs and edges differ.
            EXPECT_LE(different(after, oracle), after.size() / 100);
            EXPECT_GT(different(after, before), after.size() / 20) << "the shadows have not moved";
        }
    }
}

// Maps of single yaws follow the azimuth and stay exact: as many are rendered as there are, and no ring's.
TEST_F(MovingSun, MapsOfSingleYawsFollowTheAzimuth) {
    const scenegen::View& view = scene_.views[scene_.viewIndex("above")];
    scenegen::Sun later = scene_.sun;
    later.azimuth += 17;
    for (const auto& [rotations, due] : {std::pair("12", 8), {"16", 24}}) {  // 16 oaks and 8 firs, each at a yaw of its own
        frame::Frame frame(gpu_, view, kWidth, kHeight);
        Renderer renderer(frame, technique("instanced"), with({{"rotations", rotations}}));
        rendered(renderer);
        frame.setSun(later);
        EXPECT_EQ(texelsWritten(renderer), size_t(due) * 256 * 256);
        if (due < 24) continue;
        EXPECT_EQ(renderer.visibility(), fresh(gpu_, view, later, with({{"mode", "exact"}})));
    }
}

// A step of the azimuth by one step of the maps' rotation renumbers them: fresh maps under the new sun are the same maps.
TEST_F(MovingSun, AfterAWholeStepOfAzimuthMapsAreThoseOfAFreshStart) {
    const scenegen::View& view = scene_.views.front();
    scenegen::Sun later = scene_.sun;
    later.azimuth += 60;
    frame::Frame frame(gpu_, view, kWidth, kHeight);
    Renderer renderer(frame, technique("instanced"), with({}));
    frame.setSun(later);
    EXPECT_LE(different(rendered(renderer), fresh(gpu_, view, later, with({}))), size_t(kWidth * kHeight / 500));
}

// Whatever the policy, what is rendered anew is right: after a change of elevation cached and regenerated maps are those of
// a fresh start; round-robin's are once it has been round; a criterion's stay until a texel's worth.
TEST_F(MovingSun, ElevationMakesMapsDue) {
    const scenegen::View& view = scene_.views.front();
    scenegen::Sun later = scene_.sun;
    later.elevation -= 4;
    const std::vector<float> before = fresh(gpu_, view, scene_.sun, with({})), oracle = fresh(gpu_, view, later, with({}));
    EXPECT_GT(different(before, oracle), 500u);
    for (const char* update : {"cached", "regenerate", "criterion"}) {
        frame::Frame frame(gpu_, view, kWidth, kHeight);
        Renderer renderer(frame, technique("instanced"), with({{"update", update}}));
        rendered(renderer);
        frame.setSun(later);
        EXPECT_EQ(rendered(renderer), oracle) << update;
        EXPECT_EQ(renderer.technique()->staleness()->worstFrames, 0) << update;
    }
    frame::Frame frame(gpu_, view, kWidth, kHeight);
    Renderer renderer(frame, technique("instanced"), with({{"update", "round-robin"}, {"budget", "6"}}));
    EXPECT_EQ(rendered(renderer), before);
    frame.setSun(later);
    for (int left = 24 - 6; left >= 0; left -= 6) {  // 12 maps of oaks, 8 of firs: the fourth frame needs two
        const std::vector<float> now = rendered(renderer);
        const Staleness s = renderer.technique()->staleness().value();
        EXPECT_TRUE(left > 0 || now == oracle);
        EXPECT_NEAR(s.worstDegrees, left > 0 ? 4 : 0, 1e-6);
        EXPECT_EQ(s.worstFrames, left > 0 ? (24 - left) / 6 : 0);
    }
    // A hundredth of a degree is less than a texel of 4 cm on these trees.
    frame::Frame still(gpu_, view, kWidth, kHeight);
    Renderer patient(still, technique("instanced"), with({{"update", "criterion"}}));
    scenegen::Sun slightly = scene_.sun;
    slightly.elevation -= 0.01;
    still.setSun(slightly);
    EXPECT_EQ(texelsWritten(patient), 0u);
    EXPECT_NEAR(patient.technique()->staleness()->worstDegrees, 0.01, 1e-6);
}

// Maps that are late darken what they darkened when they were on time, wherever the present sun's volumes lie: the shadows
// are those of the sun that they show. All but the one map of twenty-four that the frame renders.
TEST_F(MovingSun, LateMapsKeepTheirWholeShadow) {
    const scenegen::View& view = scene_.views[scene_.viewIndex("above")];
    const scenegen::Sun low{scene_.sun.azimuth, 20}, high{scene_.sun.azimuth, 60};
    for (const Settings& way : {Settings{}, Settings{{"apply", "zfail"}}, Settings{{"apply", "tiled"}}, Settings{{"cull", "mask"}}}) {
        Settings axes = way;
        axes["update"] = "round-robin";
        axes["budget"] = "1";
        frame::Frame frame(gpu_, view, kWidth, kHeight);
        frame.setSun(low);
        Renderer renderer(frame, technique("instanced"), with(axes));
        const std::vector<float> then = rendered(renderer);
        const std::vector<uint8_t> litBefore = frame.readValidity();
        frame.setSun(high);
        const std::vector<float> now = rendered(renderer);
        const std::vector<uint8_t> litNow = frame.readValidity();
        size_t dark = 0, lost = 0;
        for (size_t i = 0; i < now.size(); ++i) {
            if (!litBefore[i] || !litNow[i] || then[i] > 0) continue;
            ++dark;
            lost += now[i] > 0;
        }
        EXPECT_GT(dark, 3000u);
        EXPECT_LE(lost, dark / 12);
    }
}

// A lone map follows its object's rotation; translation and uniform scale reuse it.
TEST_F(MovingSun, TranslationAndScaleReuseMapsAndARotationRendersTheOneThatTurned) {
    scenegen::Scene scene = scenegen::loadScene("box");
    size_t box = 0;
    while (!scene.prototypes[scene.instances[box].prototype].castsShadow) ++box;
    gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), kWidth, kHeight);
    Renderer renderer(frame, technique("instanced"), with({}));
    const std::vector<float> start = rendered(renderer);
    scenegen::Instance& instance = scene.instances[box];
    const auto follows = [&](size_t texels, const char* what) {
        gpu.instancesMoved();
        frame.instancesMoved();
        EXPECT_EQ(texelsWritten(renderer), texels) << what;
        const std::vector<float> now = renderer.visibility();
        const gpuscene::GpuScene otherGpu(scene);
        EXPECT_LE(different(now, fresh(otherGpu, scene.views.front(), scene.sun, with({}))), size_t(4)) << what;
        EXPECT_NE(now, start) << what;
    };
    instance.translation += glm::vec3(0.7f, -0.4f, 0.1f);
    follows(0, "translation");
    instance.scale *= 1.3f;
    follows(0, "scale");
    instance.yaw += 0.4f;
    follows(256 * 256, "rotation");
}

}  // namespace
}  // namespace dapple::shadow
