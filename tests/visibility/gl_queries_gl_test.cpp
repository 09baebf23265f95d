#include "visibility/gl_queries.h"

#include "base/random.h"
#include "frame/yard.h"
#include "gl/context.h"
#include "visibility/raster.h"

#include <gtest/gtest.h>

#include <set>

namespace dapple::visibility {
namespace {

using gpuscene::GpuScene;
using gpuscene::Hierarchy;

/// One that draws the leaves of a hierarchy over the instances.
class LeafRaster : public Raster, public LeafRenderer {
public:
    LeafRaster(const GpuScene& scene, const Hierarchy& hierarchy, int width, int height) : Raster(scene, width, height), hierarchy_(hierarchy) {}
    void draw(std::span<const uint32_t> leaves) override {
        std::set<uint32_t> kept;
        for (const uint32_t leaf : leaves) kept.insert(hierarchy_.items(leaf).begin(), hierarchy_.items(leaf).end());
        submit([&](uint32_t i) { return kept.contains(i); });
    }
    QueryState queryState() const { return {.width = depth().width(), .height = depth().height(), .depthClamp = view().parallel}; }

private:
    const Hierarchy& hierarchy_;
};

Hierarchy hierarchyOf(const GpuScene& scene, uint64_t leafTriangles) {
    std::vector<uint32_t> triangles;
    for (const scenegen::Instance& instance : scene.scene().instances) triangles.push_back(uint32_t(scene.prototypes()[instance.prototype].triangles));
    return Hierarchy(scene.instanceBoxes(), triangles, {leafTriangles, 1});
}

class GlQueriesTest : public ::testing::Test {
protected:
    GlQueriesTest() : context_(gl::Context::headless()) {}
    ~GlQueriesTest() override { EXPECT_NO_THROW(gl::checkErrors("test")); }
    gl::Context context_;
};

// The oracle of the sheet: the depth image is that of drawing everything, bit for bit, while the view jumps in each frame.
TEST_F(GlQueriesTest, CullingChangesNoBitOfTheDepth) {
    const scenegen::Scene yard = frame::yard(600);
    const GpuScene scene(yard);
    const Hierarchy hierarchy = hierarchyOf(scene, 24);
    LeafRaster raster(scene, hierarchy, 160, 120);
    for (const int kind : {0, 1, 2})  // camera, orthographic sun, warped sun
        for (const CullSettings& settings : {CullSettings{}, CullSettings{.batch = 8, .assumedVisible = 0}, CullSettings{.algorithm = Algorithm::chc}}) {
            OcclusionCuller culler(hierarchy, settings);
            ViewState state;
            GlQueries queries;
            base::Random random(21, 0, 0);
            CullView view;
            uint64_t drawn = 0, inFrustum = 0;
            for (int frame = 0; frame < 12; ++frame) {
                if (frame == 8) view.eye += glm::dvec3(0.4, 0.2, 0);
                else if (kind == 0) view = cameraAt({random.next(-20, 20), random.next(-25, 20), random.next(0.4f, 2)}, {random.next(-1, 1), random.next(-1, 1), random.next(-0.2f, 0.05f)});
                else view = sunAt({random.next(-20, 20), random.next(-20, 20), 1}, {random.next(-1, 1), random.next(-1, 1), random.next(-0.5f, -0.1f)}, random.next(5, 40), kind == 1 ? 0 : 0.7);
                raster.start(view);
                const std::vector<float> expected = raster.everything();
                raster.start(view);
                queries.use(raster.queryState());
                culler.cull(view, state, queries, raster);
                EXPECT_EQ(different(raster.read(), expected), 0u) << kind << ", frame " << frame;
                drawn += culler.leaves().size();
                for (const Hierarchy::Node& node : hierarchy.nodes()) inFrustum += node.leaf() && view.mayContain(view.relative(node.box));
            }
            EXPECT_GT(drawn, 100u);
            EXPECT_LT(drawn, inFrustum * 9 / 10) << kind;
        }
}

/// Specks, needles and flakes, each smaller than a pixel in one direction at least, strewn before the eye; the boxes of the
/// flakes are flat.
scenegen::Scene specks() {
    scenegen::Scene scene = frame::yard(0);
    scene.instances.clear();
    const glm::vec3 shapes[][2] = {{{0.02f, 0, 0}, {0, 0, 0.02f}}, {{3, 0, 0}, {0, 0, 0.004f}}, {{0, 1, 0}, {1, 0, 0}}, {{1, 0.7f, 0}, {0, 0.001f, 0.9f}}};
    for (const auto& [u, v] : shapes) {
        scenegen::Prototype& prototype = scene.prototypes.emplace_back();
        prototype.meshes.emplace_back().material = frame::kGround;
        frame::addQuad(prototype.meshes[0], {0, 0, 0}, u, v);
    }
    base::Random random(5, 0, 0);
    for (int i = 0; i < 4000; ++i)
        scene.instances.push_back({{random.next(-30, 30), random.next(-30, 30), random.next(-3, 6)}, random.next(0.3f, 1), i % 3 ? 0 : random.next(0, 6.28f), uint32_t(3 + i % 4)});
    return scene;
}

TEST_F(GlQueriesTest, CastersBelowAPixelAreNeverLost) {
    const scenegen::Scene strewn = specks();
    const GpuScene scene(strewn);
    const Hierarchy hierarchy = hierarchyOf(scene, 1);  // a leaf each
    LeafRaster raster(scene, hierarchy, 96, 72);
    GlQueries queries;
    size_t lost = 0, lostWithoutMargin = 0, covered = 0;
    // Level with the flakes, so that they are seen edge-on; along axes and askew.
    const CullView views[] = {cameraAt({0, -33, 1}, {0, 1, 0}), cameraAt({3, 2, 0.5}, {0.3, 1, -0.02}), sunAt({0, 0, 1}, {0, 1, -1e-3}, 30), sunAt({0, 0, 1}, {0.2, 0.5, -1}, 25), sunAt({0, 0, 1}, {0, 0.6, -1}, 30, 0.8)};
    for (const CullView& view : views)
        for (const double margin : {0.5, 0.0}) {
            raster.start(view);
            const std::vector<float> expected = raster.everything();
            raster.start(view);
            QueryState state = raster.queryState();
            state.margin = margin;
            queries.use(state);
            OcclusionCuller culler(hierarchy, {.algorithm = Algorithm::chcpp, .tightDepth = 0});
            ViewState fresh;  // so that everything is asked
            culler.cull(view, fresh, queries, raster);
            (margin > 0 ? lost : lostWithoutMargin) += different(raster.read(), expected);
            covered += expected.size() - size_t(std::count(expected.begin(), expected.end(), view.parallel ? 1.0f : 0.0f));
        }
    EXPECT_GT(covered, 5000u);
    EXPECT_EQ(lost, 0u);
    EXPECT_GT(lostWithoutMargin, 0u);  // what the margin is for
}

TEST_F(GlQueriesTest, AMaskKeepsWhatItIsSetFor) {
    const scenegen::Scene yard = frame::yard(600);
    const GpuScene scene(yard);
    const Hierarchy hierarchy = hierarchyOf(scene, 12);
    constexpr int kSize = 128, kCoarse = 32;
    LeafRaster raster(scene, hierarchy, kSize, kSize);
    GlQueries queries;
    const CullView view = sunAt({0, 0, 1}, {0.3, 0.5, -0.6}, 30);
    raster.start(view);
    const std::vector<float> expected = raster.everything();
    for (const GLenum format : {GL_R8, GL_R32F}) {
        gl::Texture mask(format, kCoarse, kCoarse);
        base::Random random(8, 0, 0);
        std::vector<float> set(kCoarse * kCoarse);
        for (float& texel : set) texel = random.next() < 0.05f ? 1.0f : 0.4f;
        glTextureSubImage2D(mask.name(), 0, 0, 0, kCoarse, kCoarse, GL_RED, GL_FLOAT, set.data());
        OcclusionCuller culler(hierarchy, {});
        ViewState state;
        for (int frame = 0; frame < 3; ++frame) {
            raster.start(view);
            QueryState pass = raster.queryState();
            pass.mask = &mask;
            queries.use(pass);
            culler.cull(view, state, queries, raster);
            const std::vector<float> depth = raster.read();
            for (size_t i = 0; i < depth.size(); ++i) {
                const size_t x = i % kSize * kCoarse / kSize, y = i / kSize * kCoarse / kSize;
                if (set[y * kCoarse + x] > 0.5f) { ASSERT_EQ(depth[i], expected[i]) << i; }
            }
            EXPECT_GT(different(depth, expected), 1000u);
            EXPECT_LT(culler.leaves().size(), hierarchy.nodes().size() / 3);
        }
    }
}

// Casters before a map's near plane are drawn with depth clamp; so must their boxes be, or their shadows vanish.
TEST_F(GlQueriesTest, WhatLiesBeforeTheNearPlaneIsSeen) {
    const scenegen::Scene yard = frame::yard(10);
    const GpuScene scene(yard);
    const Hierarchy hierarchy = hierarchyOf(scene, 1'000'000);
    LeafRaster raster(scene, hierarchy, 64, 64);
    const glm::dvec3 down(0, 0, -1);
    for (const bool clamp : {true, false}) {  // whatever the renderer draws with
        const CullView view = CullView::sun({0, 0, 0}, sunMatrix(down, 40, 500, 600), down);  // everything is 500 m nearer to the sun
        raster.start(view);
        (clamp ? glEnable : glDisable)(GL_DEPTH_CLAMP);
        QueryState state = raster.queryState();
        state.depthClamp = clamp;
        GlQueries queries;
        queries.use(state);
        queries.begin();
        const uint32_t root[] = {0};
        EXPECT_GT(queries.wait(queries.issue(hierarchy, view, root)), 0u);
        queries.end();
        EXPECT_EQ(glIsEnabled(GL_DEPTH_CLAMP), clamp);
    }
}

TEST_F(GlQueriesTest, AStencilTestCountsAndSamplesAreCounted) {
    const scenegen::Scene yard = frame::yard(10);
    const GpuScene scene(yard);
    const Hierarchy hierarchy = hierarchyOf(scene, 1'000'000);
    const gl::Texture depth(GL_DEPTH32F_STENCIL8, 64, 64);
    const gl::Framebuffer target = gl::makeFramebuffer({}, &depth);
    const CullView view = sunAt({0, 0, 0}, {0, 0, -1}, 40);
    gl::resetState();
    glBindFramebuffer(GL_FRAMEBUFFER, target.name());
    glViewport(0, 0, 64, 64);
    glClearBufferfi(GL_DEPTH_STENCIL, 0, 1, 3);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_STENCIL_TEST);
    const uint32_t root[] = {0};
    for (const uint64_t threshold : {0, 100})
        for (const int reference : {3, 4}) {
            GlQueries queries(threshold);
            queries.use({.width = 64, .height = 64});
            glStencilFunc(GL_EQUAL, reference, ~0u);
            queries.begin();
            const uint64_t samples = queries.wait(queries.issue(hierarchy, view, root));
            queries.end();
            if (reference == 4) { EXPECT_EQ(samples, 0u); }
            else if (threshold == 0) { EXPECT_EQ(samples, 1u); }
            else { EXPECT_GE(samples, 48u * 48); }  // the ground's 60 m of 80
        }
    glDisable(GL_STENCIL_TEST);
}

}  // namespace
}  // namespace dapple::visibility
