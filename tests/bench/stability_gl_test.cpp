// Every technique of the registry at its stiff cases, on the software rasteriser too: a new technique is tested the
// day it is added.
#include "bench/stage.h"
#include "bench/stress.h"
#include "base/random.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::bench {
namespace {

PointSpec spec(const std::string& scene, const std::string& technique, shadow::Settings axes = {}, const std::string& stress = {}) {
    PointSpec s;
    s.scene = scene;
    s.technique = technique;
    s.stressCase = stress;
    const shadow::TechniqueInfo& info = shadow::technique(technique);
    if (info.defaults.contains("size")) axes.try_emplace("size", "256");
    s.settings = shadow::resolve(info, axes);
    s.width = 160;
    s.height = 120;
    SceneFacts facts = workbench().sceneFacts(scene, {}, stress);
    // What refuses open casters gets them closed: the same forest with leaves that have a thickness.
    if (scene == "forest-small" && shadow::pruneReason(info, s.settings, facts.facts, workbench().limits())) {
        s.sceneSettings = {"species.0.leaves=solid", "species.1.leaves=solid"};
        facts = workbench().sceneFacts(scene, s.sceneSettings, stress);
        EXPECT_FALSE(shadow::pruneReason(info, s.settings, facts.facts, workbench().limits()));
    }
    s.view = facts.views.front();
    return s;
}

struct Rendered {
    std::vector<float> visibility;
    std::vector<uint8_t> validity;
    std::vector<uint8_t> picture;
    std::vector<frame::Pass> passes;
    std::vector<shadow::LightMatrix> matrices;
    std::string fallback;
};

Rendered render(const PointSpec& s) {
    const auto shared = workbench().sharedFrame(s);
    shadow::Renderer renderer(shared->frame, shadow::technique(s.technique), s.settings);
    frame::PassObserver silent;
    renderer.render(silent);
    Rendered r{renderer.visibility(), shared->frame.readValidity(), shared->frame.readShaded().texels, renderer.passes(), {}, renderer.fallback()};
    if (renderer.technique()) r.matrices = renderer.technique()->matrices();
    gl::checkErrors("a rendered point");
    return r;
}

class EveryTechnique : public testing::TestWithParam<std::string> {
protected:
    std::string name() const { return GetParam(); }
    bool hasVisibility() const { return name() != "bare"; }
};

TEST_P(EveryTechnique, IsFiniteAtEveryStiffCase) {
    if (!hasVisibility()) GTEST_SKIP() << "no visibility image";
    for (const StressCase& stress : stressCases())
        for (const char* scene : {"forest-small", "box", "nothing"}) {
            SCOPED_TRACE(stress.name + " on " + scene);
            const PointSpec s = spec(scene, name(), {}, stress.name);
            const Rendered r = render(s);
            for (const float v : r.visibility) ASSERT_TRUE(std::isfinite(v) && v >= 0 && v <= 1) << v;
            for (const shadow::LightMatrix& m : r.matrices) EXPECT_TRUE(base::allFinite(m.clipFromRelative)) << m.name;
            for (const Figure& f : workbench().open(s)->errors())
                EXPECT_TRUE(!f.value || std::isfinite(*f.value)) << f.metric;
        }
}

TEST_P(EveryTechnique, NothingIsDarkWithoutCasters) {
    if (!hasVisibility()) GTEST_SKIP() << "no visibility image";
    const Rendered r = render(spec("empty", name()));
    for (size_t i = 0; i < r.visibility.size(); ++i) ASSERT_EQ(r.visibility[i], 1) << i;
    for (const frame::Pass& pass : r.passes)  // and no map was rendered for it
        EXPECT_TRUE(!pass.name.starts_with("map") || !pass.leftOut.empty()) << pass.name;
}

TEST_P(EveryTechnique, SkyIsLitAndInvalid) {
    if (!hasVisibility() || shadow::technique(name()).family == "baseline") GTEST_SKIP() << "no shadow";
    const Rendered r = render(spec("forest-small", name(), {}, "no-receiver"));
    for (size_t i = 0; i < r.visibility.size(); ++i) {
        ASSERT_EQ(r.visibility[i], 1);
        ASSERT_EQ(r.validity[i], 0);
    }
}

TEST_P(EveryTechnique, NightIsDarkAndSaysSo) {
    if (shadow::technique(name()).family == "baseline") GTEST_SKIP() << "no shadow";
    const Rendered r = render(spec("forest-small", name(), {}, "sun-below"));
    for (const float v : r.visibility) ASSERT_EQ(v, 0);
    EXPECT_NE(r.fallback, "");
}

TEST_P(EveryTechnique, FarFromTheOriginIsTheSamePicture) {
    const Rendered here = render(spec("forest-small", name())), far = render(spec("forest-small", name(), {}, "far-origin"));
    EXPECT_EQ(here.visibility, far.visibility);
    EXPECT_EQ(here.picture, far.picture);
}

TEST_P(EveryTechnique, BadInstancesChangeNothingElseAndAreNamed) {
    const Rendered good = render(spec("forest-small", name()));
    const PointSpec s = spec("forest-small", name(), {}, "bad-instances");
    const Rendered other = render(s);
    EXPECT_EQ(good.visibility, other.visibility);
    EXPECT_EQ(good.picture, other.picture);
    size_t named = 0;
    for (const PassNote& note : workbench().open(s)->leftOut()) named += note.pass == "scene" && note.reason.find("dropped") != std::string::npos;
    EXPECT_EQ(named, 7u);
}

// A point, a line and a sheet cast what they cast: nothing that spoils another's shadow.
TEST_P(EveryTechnique, DegenerateBoxesChangeNoOtherShadow) {
    if (!hasVisibility() || shadow::technique(name()).family == "volume") GTEST_SKIP() << "no visibility image, or closed casters only";
    workbench();
    scenegen::Scene scene = scenegen::loadScene("forest-small");
    std::vector<float> visibility[2];
    for (const bool degenerate : {false, true}) {
        for (int kind = 0; degenerate && kind < 2; ++kind) {
            scenegen::Prototype prototype;
            prototype.name = kind == 0 ? "point" : "line";
            scenegen::Mesh mesh;
            mesh.positions = {{0, 0, 0}, {0, 0, kind}, {0, 0, 2 * kind}};
            mesh.normals.assign(3, {0, 0, 1});
            mesh.indices = {0, 1, 2};
            prototype.meshes.push_back(mesh);
            scene.prototypes.push_back(prototype);
            for (const float scale : {1e-6f, 1.0f}) scene.instances.push_back({{0.5f, 0.5f, 1}, scale, 0.3f, uint32_t(scene.prototypes.size() - 1)});
        }
        const gpuscene::GpuScene gpu(scene);
        frame::Frame frame(gpu, scene.views.front(), 160, 120);
        shadow::Settings axes;
        if (shadow::technique(name()).defaults.contains("size")) axes["size"] = "256";
        shadow::Renderer renderer(frame, shadow::technique(name()), shadow::resolve(shadow::technique(name()), axes));
        frame::PassObserver silent;
        renderer.render(silent);
        visibility[degenerate] = renderer.visibility();
    }
    EXPECT_EQ(visibility[0], visibility[1]);
}

TEST_P(EveryTechnique, RendersTheSamePictureTwice) {
    const Rendered a = render(spec("forest-small", name())), b = render(spec("forest-small", name()));
    EXPECT_EQ(a.visibility, b.visibility);
    EXPECT_EQ(a.picture, b.picture);
}

/// Named metric of a point.
double metric(const PointSpec& s, const std::string& wanted) {
    for (const Figure& f : workbench().open(s)->errors())
        if (f.metric == wanted) return f.value.value();
    throw std::logic_error("no metric " + wanted);
}

TEST_P(EveryTechnique, ConvergesToTheReference) {
    if (shadow::technique(name()).family == "baseline") GTEST_SKIP() << "no shadow";
    for (const char* scene : {"box", "sphere"}) {
        if (!shadow::technique(name()).defaults.contains("size")) {  // nothing to refine: it is there
            PointSpec s = spec(scene, name());
            s.width = 320, s.height = 240;
            EXPECT_LE(metric(s, "error"), metric(s, "half_pixel_sensitivity")) << scene;
            continue;
        }
        PointSpec coarse = spec(scene, name(), {{"size", "64"}}), middle = spec(scene, name(), {{"size", "512"}}),
                  fine = spec(scene, name(), {{"size", "4096"}});
        for (PointSpec* s : {&coarse, &middle, &fine}) s->width = 320, s->height = 240;
        const double e64 = metric(coarse, "error"), e512 = metric(middle, "error"), e4096 = metric(fine, "error");
        EXPECT_LT(e512, e64) << scene;
        // Once both are below what half a pixel's shift would cost, single pixels decide which is smaller.
        const double halfPixel = metric(fine, "half_pixel_sensitivity");
        EXPECT_LE(e4096, std::max(e512, halfPixel)) << scene;
        EXPECT_LE(e4096, 2 * halfPixel) << scene;
    }
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryTechnique, testing::ValuesIn([] {
                             std::vector<std::string> names;
                             for (const shadow::TechniqueInfo& known : shadow::techniques()) names.push_back(known.name);
                             return names;
                         }()),
                         [](const auto& test) {
                             std::string name = test.param;
                             std::ranges::replace(name, '-', '_');
                             return name;
                         });

// What is left out must not change a pixel.

class EveryMap : public testing::TestWithParam<std::string> {};

TEST_P(EveryMap, CullingCastersChangesNoPixel) {
    for (const char* stress : {"", "sun-1deg", "sun-zenith", "parallel-1e-3", "duelling", "depth-range"})
        for (const char* filter : {"nearest", "pcf2", "pcf3"}) {
            SCOPED_TRACE(std::string(stress) + " " + filter);
            const Rendered culled = render(spec("forest-small", GetParam(), {{"cull", "frustum"}, {"filter", filter}}, stress));
            const Rendered all = render(spec("forest-small", GetParam(), {{"cull", "none"}, {"filter", filter}}, stress));
            EXPECT_EQ(culled.visibility, all.visibility);
        }
}
INSTANTIATE_TEST_SUITE_P(Registry, EveryMap, testing::Values("uniform", "focused", "lispsm", "cascaded"), [](const auto& test) { return test.param; });

TEST(LeftOut, BackFacesOfSingleSidedMaterialsAreNotMissed) {
    workbench();  // its context is current
    scenegen::Scene scene = scenegen::loadScene("forest-small");
    std::vector<float> visibility[2], depth[2];
    std::vector<uint8_t> picture[2];
    for (int twoSided = 0; twoSided < 2; ++twoSided) {
        for (scenegen::Material& material : scene.materials) material.doubleSided |= twoSided == 1;
        const gpuscene::GpuScene gpu(scene);
        frame::Frame frame(gpu, scene.views.front(), 160, 120);
        shadow::Renderer renderer(frame, shadow::technique("cascaded"), shadow::technique("cascaded").defaults);
        frame::PassObserver silent;
        renderer.render(silent);
        visibility[twoSided] = renderer.visibility();
        picture[twoSided] = frame.readShaded().texels;
        depth[twoSided] = frame.readChannel(frame.depth()).texels;
    }
    // Not bit-exact: vertices snap to 1/256 pixel, so where a twig is thinner than a pixel its back can come out nearer
    // than its front, by less than its thickness. There the other face is drawn, and nowhere else.
    size_t other = 0;
    for (size_t i = 0; i < visibility[0].size(); ++i) {
        if (depth[0][i] != depth[1][i]) {
            ++other;
            EXPECT_NEAR(depth[0][i] / depth[1][i], 1, 1e-4) << i;  // eye depth is proportional to 1 / depth
            continue;
        }
        EXPECT_EQ(visibility[0][i], visibility[1][i]) << i;
        EXPECT_TRUE(std::equal(&picture[0][3 * i], &picture[0][3 * i] + 3, &picture[1][3 * i])) << i;
    }
    EXPECT_LE(other, 6u);
}

TEST(LeftOut, CachedMapsAreTheRegeneratedOnes) {
    EXPECT_EQ(render(spec("forest-small", "instanced", {{"update", "cached"}})).visibility,
              render(spec("forest-small", "instanced", {{"update", "regenerate"}})).visibility);
}

TEST(LeftOut, RotatedMapsOfAnUnrotatedSceneAreNotMissed) {
    const Rendered twelve = render(spec("box", "instanced")), one = render(spec("box", "instanced", {{"rotations", "1"}, {"mode", "nearest"}}));
    EXPECT_EQ(twelve.visibility, one.visibility);
    bool said = false;
    for (const frame::Pass& pass : twelve.passes) said |= pass.leftOut.find("rotated") != std::string::npos;
    EXPECT_TRUE(said);
}

TEST(Fallback, LispsmAlongTheLightIsTheFocusedMap) {
    for (const char* stress : {"parallel-0", "parallel-1e-7", "parallel-1e-3", "duelling"}) {
        const Rendered warped = render(spec("forest-small", "lispsm", {}, stress)), focused = render(spec("forest-small", "focused", {}, stress));
        EXPECT_NE(warped.fallback.find("frustum"), std::string::npos) << stress;
        EXPECT_EQ(warped.visibility, focused.visibility) << stress;
    }
}

// On its maps' own angles an instanced map is a per-object map: sample frames and modes agree bit for bit.
TEST(Instanced, OnAMapsAngleModesAndFramesAgree) {
    const Rendered nearest = render(spec("box", "instanced", {{"mode", "nearest"}}));
    for (const char* mode : {"nearest", "blend", "depth"})
        for (const char* sampleFrame : {"A", "B"})
            EXPECT_EQ(render(spec("box", "instanced", {{"mode", mode}, {"sample-frame", sampleFrame}})).visibility, nearest.visibility) << mode << sampleFrame;
}

// However pixels and casters find each other, the visibility image is the same (tests/shadow/apply_gl_test.cpp: in every product).
TEST(Instanced, StiffCasesAreTheSamePixelsInEveryWayToApplyTheMaps) {
    for (const char* stress : {"sun-1deg", "sun-zenith", "duelling", "depth-range"}) {
        const Rendered base = render(spec("forest-small", "instanced", {}, stress));
        for (shadow::Settings way : {shadow::Settings{{"apply", "zfail"}}, {{"apply", "tiled"}}, {{"apply", "all"}}, {{"cull", "mask"}, {"apply", "zfail"}}, {{"cull", "mask"}}}) {
            SCOPED_TRACE(stress);
            const Rendered other = render(spec("forest-small", "instanced", way, stress));
            EXPECT_EQ(base.visibility, other.visibility);
            EXPECT_EQ(base.validity, other.validity);
        }
    }
}

// Oracle: a map per instance at its own rotation. At a map's own angle every sample frame is that map's, and modes agree.
TEST(Instanced, OnAMapsAngleEveryModeIsTheExactMap) {
    workbench();
    scenegen::Scene scene = scenegen::loadScene("forest-small");
    base::Random random(1, 0, 0);
    for (scenegen::Instance& instance : scene.instances) {
        instance.yaw = float(2 * std::numbers::pi * double(int(random.next(0, 12))) / 12);
        instance.scale = 1;
    }
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), 160, 120);
    const auto visibility = [&](const shadow::Settings& axes) {
        shadow::Settings settings = shadow::resolve(shadow::technique("instanced"), axes);
        settings["size"] = "256";
        shadow::Renderer renderer(frame, shadow::technique("instanced"), settings);
        frame::PassObserver silent;
        renderer.render(silent);
        return renderer.visibility();
    };
    const std::vector<float> exact = visibility({{"mode", "exact"}});
    EXPECT_GT(std::count(exact.begin(), exact.end(), 0.0f), 1000);
    for (const char* mode : {"nearest", "blend", "depth"})
        for (const char* sampleFrame : {"A", "B", "E", "EB"}) {
            const std::vector<float> other = visibility({{"mode", mode}, {"sample-frame", sampleFrame}});
            size_t different = 0;
            for (size_t i = 0; i < exact.size(); ++i) different += exact[i] != other[i];
            // The exact map's rotation is the instance's float, the shared one's the double that it was rounded from.
            EXPECT_LE(different, exact.size() / 2000) << mode << " " << sampleFrame;
        }
}

// Moving the camera hands own maps to other instances; what comes out is what a fresh start gives.
TEST(Instanced, OwnMapsFollowTheView) {
    workbench();
    const scenegen::Scene scene = scenegen::loadScene("forest-small");
    const gpuscene::GpuScene gpu(scene);
    const shadow::TechniqueInfo& info = shadow::technique("instanced-near");
    shadow::Settings settings = shadow::resolve(info, {{"size", "128"}, {"own", "3"}});
    frame::PassObserver silent;
    frame::Frame frame(gpu, scene.views.front(), 160, 120);
    shadow::Renderer walking(frame, info, settings);
    size_t rendered = 0;
    for (const scenegen::View& view : scene.views) {
        frame.look(view);
        walking.replan();
        for (const frame::Pass& pass : walking.passes()) rendered += pass.name == "maps" && pass.leftOut.empty();
        walking.render(silent);
        const std::vector<float> there = walking.visibility();
        frame::Frame fresh(gpu, view, 160, 120);
        shadow::Renderer start(fresh, info, settings);
        start.render(silent);
        EXPECT_EQ(there, start.visibility()) << view.name;
    }
    EXPECT_GT(rendered, 0u) << "no view of the walk needed another map";
    settings["own"] = "2048";  // more than there are instances: mode exact by another name
    shadow::Renderer all(frame, info, settings);
    all.render(silent);
    const std::vector<float> own = all.visibility();
    shadow::Renderer exact(frame, info, shadow::resolve(info, {{"size", "128"}, {"mode", "exact"}}));
    exact.render(silent);
    // The comparison is the sampler's in one and the shader's in the other; both compare a depth with a reference.
    size_t different = 0;
    const std::vector<float> reference = exact.visibility();
    for (size_t i = 0; i < own.size(); ++i) different += own[i] != reference[i];
    EXPECT_LE(different, own.size() / 2000);
}

TEST(Limits, AMapBeyondTheGlLimitIsRefusedWithAReason) {
    const auto reason = shadow::pruneReason(shadow::technique("uniform"), spec("box", "uniform", {{"size", "32768"}}).settings, {}, workbench().limits());
    ASSERT_TRUE(reason);
    EXPECT_NE(reason->find("16384"), std::string::npos);
}

}  // namespace
}  // namespace dapple::bench
