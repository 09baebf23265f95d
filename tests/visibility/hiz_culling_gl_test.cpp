#include "visibility/hiz_culling.h"

#include "base/random.h"
#include "frame/yard.h"
#include "gl/context.h"
#include "scenegen/primitives.h"
#include "visibility/raster.h"

#include <gtest/gtest.h>

namespace dapple::visibility {
namespace {

class HizCullingTest : public ::testing::Test {
protected:
    HizCullingTest() : context_(gl::Context::headless()) {}
    ~HizCullingTest() override { EXPECT_NO_THROW(gl::checkErrors("test")); }
    gl::Context context_;
};

/// The yard, with walls about it and crates of all sizes between them.
scenegen::Scene crates() {
    scenegen::Scene scene = frame::yard(200);
    base::Random random(4, 0, 0);
    const auto first = uint32_t(scene.prototypes.size());
    for (const glm::vec3& size : {glm::vec3(12, 0.4f, 5), glm::vec3(0.3f), glm::vec3(1.5f, 1, 0.8f), glm::vec3(0.1f, 0.1f, 6), glm::vec3(3, 2, 0)}) {
        scenegen::Prototype& prototype = scene.prototypes.emplace_back();
        prototype.meshes.push_back(scenegen::boxMesh(size));
        prototype.meshes.back().material = frame::kGround;
    }
    for (uint32_t i = 0; i < 1500; ++i)
        scene.instances.push_back({{random.next(-28, 28), random.next(-28, 28), random.next(0, 4)}, random.next(0.3f, 1), i % 3 ? random.next(0, 6.28f) : 0, first + (i % 25 ? 1 + i % 4 : 0)});
    return scene;
}

// Each view twice, so that the first phase has something to draw; images whose pixels are not those of the cells.
TEST_F(HizCullingTest, ChangesNoBitOfTheDepthAndDrawsLess) {
    const scenegen::Scene yard = crates();
    const gpuscene::GpuScene scene(yard);
    const std::pair<int, int> sizes[] = {{160, 120}, {128, 128}, {100, 100}, {300, 70}, {523, 45}, {2061, 29}};
    for (const int kind : {0, 1, 2})  // camera, orthographic sun, warped sun
        for (const auto& [width, height] : sizes) {
            Raster raster(scene, width, height);
            HizCulling culling(scene.items(), {.pixels = {width, height}, .reversed = kind == 0});
            base::Random random(21, 0, 0);
            size_t drawn = 0, inFrustum = 0;
            CullView view;
            for (int frame = 0; frame < 24; ++frame) {
                if (frame % 2) view.eye += glm::dvec3(0.02, 0.01, 0);
                else if (kind == 0) view = cameraAt({random.next(-20, 20), random.next(-25, 20), random.next(0.4f, 2)}, {random.next(-1, 1), random.next(-1, 1), random.next(-0.2f, 0.05f)});
                else view = sunAt({random.next(-20, 20), random.next(-20, 20), 1}, {random.next(-1, 1), random.next(-1, 1), random.next(-0.5f, -0.1f)}, random.next(5, 40), kind == 1 ? 0 : 0.7);
                raster.start(view);
                const std::vector<float> expected = raster.everything();
                raster.start(view);
                culling.draw({.view = view, .leastW = kind == 0 ? 0.6 : 0.05, .depth = &raster.depth(), .depthClamp = kind != 0}, [&](const gpuscene::DrawList& list) { raster.submit(list); });
                ASSERT_EQ(different(raster.read(), expected), 0u) << "kind " << kind << ", " << width << " pixels, frame " << frame;
                if (frame % 2 == 0) continue;
                drawn += culling.drawn().size();
                for (const base::Box& box : scene.instanceBoxes()) inFrustum += view.mayContain(view.relative(box));
            }
            EXPECT_GT(drawn, 1000u);
            EXPECT_LT(drawn * 100, inFrustum * 63) << "kind " << kind << ", " << width << " pixels";
        }
}

// A wall, and behind it crates in groups close together: seen from beside it, then from before it. Whether they are hidden as groups
// or one by one, a frame later they are forgotten.
TEST_F(HizCullingTest, ForgetsWhatIsHidden) {
    scenegen::Scene yard;
    yard.materials.resize(1);
    for (const glm::vec3& size : {glm::vec3(20, 0.5f, 10), glm::vec3(0.2f)}) yard.prototypes.emplace_back().meshes.push_back(scenegen::boxMesh(size));
    yard.instances.push_back({{0, 0, 5}, 1, 0, 0});
    constexpr uint32_t kCrates = 400;
    for (uint32_t i = 0; i < kCrates; ++i) yard.instances.push_back({{float(i % 20) * 0.5f - 5, 8 + float(i / 20) * 0.5f, 0.2f}, 1, 0, 1});
    const gpuscene::GpuScene scene(yard);
    Raster raster(scene, 256, 256);
    HizCulling culling(scene.items(), {.pixels = {256, 256}, .reversed = true});
    const auto drawn = [&](const CullView& view) {
        raster.start(view);
        culling.draw({.view = view, .leastW = 0.6, .depth = &raster.depth()}, [&](const gpuscene::DrawList& list) { raster.submit(list); });
        return culling.drawn().size();
    };
    const CullView beside = cameraAt({25, 10, 6}, {-1, 0.1, -0.25}), before = cameraAt({0, -15, 2}, {0, 1, 0});
    drawn(beside);
    EXPECT_GT(drawn(beside), kCrates * 3 / 4);
    drawn(before);
    EXPECT_LE(drawn(before), 3u);
    EXPECT_GT(drawn(beside), kCrates * 3 / 4);
}

}  // namespace
}  // namespace dapple::visibility
