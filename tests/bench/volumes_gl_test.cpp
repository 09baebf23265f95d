// Stencil shadow volumes against the ray tracer: they follow the casters' own triangles, so what separates the two is the
// rasteriser's grid alone.
#include "base/error.h"
#include "bench/stage.h"
#include "bench/stress.h"
#include "scenegen/library.h"
#include "truth/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::bench {
namespace {

using scenegen::Scene;

std::vector<std::string> solidLeaves(const std::string& scene) {
    if (scene != "forest-small") return {};
    return {"species.0.leaves=solid", "species.1.leaves=solid"};
}

Scene load(const std::string& name) { return scenegen::loadScene(name, solidLeaves(name)); }

/// The technique's picture of a scene's first view, and what the ray tracer says of it.
struct Judged {
    std::vector<float> visibility;
    truth::Reference reference;
    truth::ErrorMetrics metrics;
    double halfPixel = 0;  ///< truth::halfPixelSensitivity()
    size_t pixels(double share) const { return size_t(std::lround(share * metrics.valid * double(visibility.size()))); }
};

Judged judge(const Scene& scene, const shadow::Settings& axes = {}) {
    workbench();  // its context is current
    const shadow::TechniqueInfo& info = shadow::technique("stencil-volumes");
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), 320, 240);
    shadow::Renderer renderer(frame, info, shadow::resolve(info, axes));
    frame::PassObserver silent;
    renderer.render(silent);
    gl::checkErrors("shadow volumes");
    const truth::Tracer tracer(scene);
    const auto trace = [&] { return tracer.trace(frame.readReceivers(), frame.camera().eye, frame.light()); };
    Judged judged{renderer.visibility(), trace(), {}};
    judged.metrics = truth::measureError(judged.reference, judged.visibility);
    const frame::Pass gbuffer = frame.gbufferPass();
    std::vector<truth::Reference> shifted;
    for (const glm::dvec2& pixels : {glm::dvec2(0.5, 0), glm::dvec2(0, 0.5)}) {
        frame.shiftBy(pixels);
        frame::execute({&gbuffer, 1}, silent);
        shifted.push_back(trace());
    }
    judged.halfPixel = truth::halfPixelSensitivity(judged.reference, shifted);
    return judged;
}

/// Vertices snap to the nearest point of a grid of 1/256 pixel, those of the volumes and those of what they fall on: an edge
/// moves by less than 1/128 pixel against the truth, and half a pixel costs the half-pixel sensitivity. Three pixels beside that,
/// because few pixels are no statistics.
void expectExact(const Judged& judged) {
    const truth::ErrorMetrics& m = judged.metrics;
    EXPECT_LE(double(judged.pixels(m.error)), double(judged.pixels(judged.halfPixel)) / 64 + 3);
}

TEST(StencilVolumes, AreTheRayTracersShadows) {
    for (const char* name : {"box", "sphere", "slab", "forest-small"})
        for (const char* stress : {"none", "sun-1deg", "sun-zenith", "duelling", "depth-range", "parallel-0", "far-origin"}) {
            SCOPED_TRACE(std::string(name) + " " + stress);
            Scene scene = load(name);
            stressCase(stress).apply(scene);
            const Judged judged = judge(scene);
            expectExact(judged);
            EXPECT_TRUE(judged.metrics.shadowed > 0.005 || *stress != 'n');
        }
}

/// A box of 2 m, turned and scaled, that floats above the plane of the scene "box".
Scene turnedBox() {
    Scene scene = load("box");
    for (scenegen::Instance& instance : scene.instances)
        if (scene.prototypes[instance.prototype].castsShadow) instance.yaw = 0.7f, instance.scale = 1.7f;
    return scene;
}

TEST(StencilVolumes, FollowAnInstancesYawAndScale) {
    const Judged judged = judge(turnedBox());
    expectExact(judged);
    EXPECT_GT(judged.metrics.shadowed, 0.01);
}

TEST(StencilVolumes, MayHoldTheEye) {
    // From within the box's shadow, toward its rim; the sun stands at azimuth 135°, elevation 45°: light goes to (-1, 1, -√2).
    Scene scene = turnedBox();
    scenegen::View& view = scene.views.front();
    const glm::dvec3 centre(0, 0, 2);
    view.eye = centre + scene.sun.direction() * 2.2;
    for (const glm::dvec3 forward : {glm::dvec3(1, 0.2, -0.4), glm::dvec3(-1, 0.4, -0.2), glm::dvec3(0.1, 1, -0.5), glm::dvec3(0.1, 0, -1)}) {
        view.forward = glm::normalize(forward);
        view.up = glm::normalize(glm::cross(glm::cross(view.forward, glm::dvec3(0.3, 0.1, 1)), view.forward));
        const Judged judged = judge(scene);
        expectExact(judged);
        EXPECT_GT(judged.metrics.shadowed, 0.01);
    }
}

TEST(StencilVolumes, MayBeCutByTheNearPlane) {
    // Onto the lit top and side of the box, the near plane within it: what is left of lit faces must stay lit.
    Scene scene = turnedBox();
    scenegen::View& view = scene.views.front();
    for (const double height : {4.0, 3.9, 3.8}) {
        view.eye = {1.2, -1.4, height};
        view.near = 0.6;
        view.forward = glm::normalize(glm::dvec3(-0.5, 1, -0.6));
        view.up = glm::normalize(glm::cross(glm::cross(view.forward, glm::dvec3(0, 0, 1)), view.forward));
        const Judged judged = judge(scene);
        expectExact(judged);
        EXPECT_GT(judged.metrics.valid, 0.2);
    }
}

TEST(StencilVolumes, CullingCastersChangesNoPixel) {
    for (const char* stress : {"none", "sun-1deg", "duelling"}) {
        Scene scene = load("forest-small");
        stressCase(stress).apply(scene);
        EXPECT_EQ(judge(scene).visibility, judge(scene, {{"cull", "none"}}).visibility) << stress;
    }
}

TEST(StencilVolumes, MayBeCutByTheNearPlaneInAForest) {
    Scene scene = load("forest-small");
    for (const double near : {1.0, 3.0, 7.0, 15.0}) {
        SCOPED_TRACE(near);
        scene.views.front().near = near;
        expectExact(judge(scene));
    }
}

/// `count` boxes over one another, each a little smaller than the one below it, above the plane of the scene "box".
Scene pile(int count) {
    Scene scene = load("box");
    uint32_t box = 0;
    while (!scene.prototypes[box].castsShadow) ++box;
    std::erase_if(scene.instances, [&](const scenegen::Instance& i) { return i.prototype == box; });
    for (int i = 0; i < count; ++i) scene.instances.push_back({{0, 0, 1 + 0.02f * float(i)}, 0.7f - 0.001f * float(i), 0, box});
    scene.sun.elevation = 90;
    return scene;
}

// Eight bits of stencil: 256 volumes over one another are counted as none. Sums are not.
TEST(StencilVolumes, StencilsWrapAt256VolumesAndSumsDoNot) {
    for (const int count : {255, 256, 257}) {
        const Scene scene = pile(count);
        SCOPED_TRACE(count);
        const Judged stencil = judge(scene), sum = judge(scene, {{"count", "sum"}});
        expectExact(sum);
        EXPECT_GT(sum.metrics.shadowed, 0.002);
        if (count == 256) {
            EXPECT_GT(stencil.pixels(stencil.metrics.falseLight), 50u);
        } else {
            EXPECT_EQ(stencil.visibility, sum.visibility);
        }
    }
}

TEST(StencilVolumes, SumsAndStencilsAgreeInAForest) {
    Scene scene = load("forest-small");
    EXPECT_EQ(judge(scene).visibility, judge(scene, {{"count", "sum"}}).visibility);
}

TEST(StencilVolumes, RefuseOpenCasters) {
    const shadow::TechniqueInfo& info = shadow::technique("stencil-volumes");
    const Scene open = scenegen::loadScene("forest-small"), closed = load("forest-small");
    const auto reason = shadow::pruneReason(info, info.defaults, open.facts(), {});
    ASSERT_TRUE(reason);
    EXPECT_NE(reason->find("open"), std::string::npos);
    EXPECT_FALSE(shadow::pruneReason(info, info.defaults, closed.facts(), {}));
    EXPECT_FALSE(shadow::pruneReason(info, info.defaults, load("empty").facts(), {}));
    EXPECT_THROW(judge(open), base::UsageError);  // whoever does not ask
    scenegen::Facts holes = closed.facts();
    holes.alphaTested = true;
    EXPECT_TRUE(shadow::pruneReason(info, info.defaults, holes, {}));
    EXPECT_TRUE(shadow::pruneReason(info, shadow::resolve(info, {{"cull", "mask"}}), closed.facts(), {}));
}

TEST(StencilVolumes, OverdrawCountsEachFragmentOfTheVolume) {
    // From above, sun at the zenith: a pixel of the box's top sees its near and its far cap, one beside the shadow nothing.
    Scene scene = load("box");
    scene.sun.elevation = 90;
    scenegen::View& view = scene.views.front();
    view.eye = {0, 0, 12};
    view.forward = {0, 0, -1};
    view.up = {0, 1, 0};
    workbench();
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, view, 160, 120);
    const shadow::TechniqueInfo& info = shadow::technique("stencil-volumes");
    shadow::Renderer renderer(frame, info, info.defaults);
    const base::ImageF fragments = renderer.volumeOverdraw().value();
    EXPECT_EQ(fragments.texels[60 * 160 + 80], 2);
    EXPECT_EQ(fragments.texels[60 * 160 + 5], 0);
}

}  // namespace
}  // namespace dapple::bench
