// Counters of maps: triangles against the GPU's own count, fill against an additive picture of the same casters.
#include "bench/stage.h"
#include "shadow/families.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

namespace dapple::bench {
namespace {

PointSpec spec(const char* scene, const std::string& technique, const shadow::Settings& axes) {
    PointSpec s;
    s.scene = scene;
    s.technique = technique;
    s.settings = shadow::resolve(shadow::technique(technique), axes);
    s.view = workbench().sceneFacts(scene, {}, "").views.front();
    s.width = 160, s.height = 120;
    return s;
}

std::map<std::string, std::map<std::string, double>> counters(const PointSpec& s) {
    const auto point = workbench().open(s);
    for (int i = 0; i < 2; ++i) point->submitFrame(false);
    point->drain();
    std::map<std::string, std::map<std::string, double>> found;
    for (const Figure& f : point->counters())
        if (f.value) found[f.pass][f.metric] = *f.value;
    return found;
}

TEST(Fill, TrianglesAreThoseThatTheGpuWasGiven) {
    const std::vector<std::pair<std::string, shadow::Settings>> points{
        {"uniform", {{"cull", "hiz"}, {"camera", "hiz"}}}, {"uniform", {{"cull", "pyramid"}}}, {"uniform", {{"cull", "receivers"}}}, {"uniform", {{"cull", "chcpp"}}},
        {"cascaded", {{"cull", "pyramid"}, {"camera", "hiz"}}}, {"instanced", {{"cull", "mask"}}}, {"instanced", {{"update", "regenerate"}}}};
    for (auto [technique, axes] : points) {
        axes.insert({"size", "256"});
        SCOPED_TRACE(technique + " " + axes.begin()->first + " " + axes.begin()->second);
        size_t passes = 0;
        for (const auto& [pass, value] : counters(spec("forest-small", technique, axes))) {
            if (pass != "gbuffer" && !pass.starts_with("map") && pass != "volumes") continue;
            ASSERT_TRUE(value.contains("primitives_submitted"));
            // Boxes of occlusion queries, 12 triangles each, are no casters.
            const double boxes = value.contains("occlusion_boxes") ? 12 * value.at("occlusion_boxes") : 0;
            EXPECT_EQ(value.at("triangles_submitted") + boxes, value.at("primitives_submitted")) << pass;
            ++passes;
        }
        EXPECT_GE(passes, 2u);
    }
}

/// Fragments of each texel of a map, by blending: all, or those before the far plane, which alone a cleared map keeps.
std::vector<float> fragments(shadow::Renderer& renderer, const gpuscene::GpuScene& scene, const frame::Frame& frame, size_t matrix, int size, bool beforeFar) {
    const gl::Texture counts(GL_R32F, size, size);
    const gl::Texture depth(GL_DEPTH_COMPONENT32F, size, size);
    const gl::Texture* colours[] = {&counts};
    const gl::Framebuffer target = gl::makeFramebuffer(colours, &depth);
    const gl::Program opaque("shadow/map_depth.vert", "passes/count.frag"), alpha("shadow/map_depth.vert", "passes/count.frag", {"ALPHA_TEST"});
    gl::resetState();
    glBindFramebuffer(GL_FRAMEBUFFER, target.name());
    glViewport(0, 0, size, size);
    const float zero[4] = {};
    glClearBufferfv(GL_COLOR, 0, zero);
    const float one = 1;
    glClearBufferfv(GL_DEPTH, 0, &one);
    if (beforeFar) glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glEnable(GL_DEPTH_CLAMP);
    shadow::setCasterClip(renderer.technique()->matrices()[matrix].clipFromRelative, opaque, alpha);
    renderer.redrawCasters(matrix, [&](const gpuscene::DrawList& list) {
        measure::Ledger ignored;
        shadow::drawCasters(scene, list, opaque, alpha, ignored);
    });
    gl::resetState();
    return frame.readChannel(counts).texels;
}

TEST(Fill, MapsHaveTheFragmentsAndTexelsThatBlendingFinds) {
    for (const auto& [technique, cull] : {std::pair("uniform", "none"), {"uniform", "hiz"}, {"uniform", "pyramid"}, {"uniform", "receivers"}, {"lispsm", "frustum"}, {"cascaded", "frustum"}}) {
        SCOPED_TRACE(std::string(technique) + " " + cull);
        const PointSpec s = spec("forest-small", technique, {{"size", "256"}, {"cull", cull}});
        const auto shared = workbench().sharedFrame(s);
        shadow::Renderer renderer(shared->frame, shadow::technique(technique), s.settings);
        frame::PassObserver silent;
        for (int i = 0; i < 3; ++i) renderer.render(silent);  // as the counted frame's culling finds things
        std::vector<double> expected, filled;
        for (size_t m = 0; m < renderer.technique()->matrices().size(); ++m) {
            const auto count = [&](bool beforeFar) { return fragments(renderer, shared->loaded->gpu, shared->frame, m, 256, beforeFar); };
            const std::vector<float> all = count(false), kept = count(true);
            expected.push_back(std::accumulate(all.begin(), all.end(), 0.0));
            filled.push_back(double(std::ranges::count_if(kept, [](float v) { return v > 0; })));
        }
        size_t map = 0;
        auto found = counters(s);
        for (const auto& [pass, value] : found) {
            if (!pass.starts_with("map")) continue;
            EXPECT_EQ(value.at("map_fragments"), expected[map]) << pass;
            EXPECT_EQ(value.at("map_texels_filled"), filled[map]) << pass;
            EXPECT_DOUBLE_EQ(value.at("map_overdraw"), expected[map] / filled[map]) << pass;
            ++map;
        }
        EXPECT_EQ(map, expected.size());
        const auto& frame = found.at("");
        EXPECT_EQ(frame.at("map_fragments"), std::accumulate(expected.begin(), expected.end(), 0.0));
        EXPECT_GT(frame.at("map_overdraw"), 1.2);
        EXPECT_GT(frame.at("geometry_overdraw_mean"), 0.3);
        EXPECT_FALSE(frame.contains("volume_overdraw_mean"));
    }
}

// A box, seen along the sun by its front faces alone, covers each texel once, and most of the map that is fitted to it.
TEST(Fill, AMapOfOneBoxHasNoOverdraw) {
    const auto found = counters(spec("box", "instanced", {{"size", "256"}, {"update", "regenerate"}}));
    const auto& map = found.at("maps");
    EXPECT_EQ(map.at("map_fragments"), map.at("map_texels_filled"));
    EXPECT_GT(map.at("map_texels_filled"), 0.4 * 256 * 256);
    EXPECT_LT(map.at("map_texels_filled"), 256 * 256);
    EXPECT_TRUE(found.at("").contains("volume_overdraw_mean"));
    EXPECT_LE(found.at("").at("candidates_mean"), found.at("").at("volume_overdraw_mean"));
}

}  // namespace
}  // namespace dapple::bench
