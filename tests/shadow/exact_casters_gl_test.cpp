// Stencil volumes for some casters and maps for the others, in one image: each caster's shadow is that of its own technique.
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::shadow {
namespace {

class ExactCasters : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);

    static std::vector<float> visibility(const scenegen::Scene& scene, const char* name, Settings axes, size_t* failedPasses = nullptr) {
        const gpuscene::GpuScene gpu(scene);
        std::vector<float> all;
        for (const scenegen::View& view : scene.views) {
            frame::Frame frame(gpu, view, 160, 120);
            Renderer renderer(frame, technique(name), resolve(technique(name), axes));
            frame::PassObserver silent;
            renderer.render(silent);
            const std::vector<float> v = renderer.visibility();
            all.insert(all.end(), v.begin(), v.end());
            if (failedPasses)
                for (const frame::Pass& pass : renderer.passes()) *failedPasses += pass.name.starts_with("exact") && !pass.leftOut.empty();
        }
        return all;
    }
    /// The scene where only closed casters cast, or only the others.
    static scenegen::Scene only(scenegen::Scene scene, bool closed) {
        for (scenegen::Prototype& prototype : scene.prototypes) prototype.castsShadow &= prototype.closed == closed;
        return scene;
    }
};

TEST_F(ExactCasters, EachCastersShadowIsThatOfItsOwnTechnique) {
    // One species' leaves have a thickness, the other's have none.
    const scenegen::Scene scene = scenegen::loadScene("forest-small", {"species.0.leaves=solid"});
    const std::vector<float> volumes = visibility(only(scene, true), "stencil-volumes", {}), mapped = visibility(only(scene, false), "instanced", {{"size", "256"}});
    EXPECT_GT(std::ranges::count(volumes, 0.0f), 1000);
    EXPECT_GT(std::ranges::count(mapped, 0.0f), 1000);
    std::vector<float> expected;
    for (size_t i = 0; i < volumes.size(); ++i) expected.push_back(std::min(volumes[i], mapped[i]));
    for (const char* apply : {"zpass", "zfail", "skip"})
        for (const char* accumulate : {"min", "multiply"})
            EXPECT_EQ(visibility(scene, "instanced", {{"size", "256"}, {"exact-casters", "1000000"}, {"apply", apply}, {"accumulate", accumulate}}), expected) << apply << " " << accumulate;
}

TEST_F(ExactCasters, OfNoneAndOfAllIsOneTechniqueAlone) {
    const scenegen::Scene open = scenegen::loadScene("forest-small"), closed = scenegen::loadScene("box");
    size_t leftOut = 0;
    EXPECT_EQ(visibility(open, "instanced", {{"size", "256"}, {"exact-casters", "1000000"}}, &leftOut), visibility(open, "instanced", {{"size", "256"}}));
    EXPECT_EQ(leftOut, 2 * open.views.size());
    EXPECT_EQ(visibility(closed, "instanced", {{"exact-casters", "12"}}), visibility(closed, "stencil-volumes", {}));
    EXPECT_EQ(visibility(closed, "instanced", {{"exact-casters", "11"}}), visibility(closed, "instanced", {})) << "the box has 12 triangles";
    scenegen::Scene translucent = closed;
    for (scenegen::Prototype& prototype : translucent.prototypes)
        if (prototype.castsShadow) prototype.transmittance = 0.5f;
    const std::vector<float> half = visibility(translucent, "instanced", {{"exact-casters", "12"}, {"accumulate", "multiply"}});
    EXPECT_GT(std::ranges::count(half, 0.5f), 100) << "a counted volume would let nothing through";
    EXPECT_EQ(half, visibility(translucent, "instanced", {{"accumulate", "multiply"}}));
}

}  // namespace
}  // namespace dapple::shadow
