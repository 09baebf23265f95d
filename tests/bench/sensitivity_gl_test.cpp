// The half-pixel sensitivity against pictures of twice the resolution, whose neighbouring pixels lie half a pixel apart.
#include "bench/stage.h"

#include <gtest/gtest.h>

namespace dapple::bench {
namespace {

PointSpec spec(const char* scene, const char* view, int width, int height) {
    PointSpec s;
    s.scene = scene;
    s.view = view;
    s.width = width, s.height = height;
    return s;
}

/// Share of the pairs of pixels, side by side or one above the other, whose labels differ.
double differingPairs(const truth::Reference& g, bool upwards) {
    size_t both = 0, differing = 0;
    for (int y = 0; y + 1 < g.height; y += 2)
        for (int x = 0; x + 1 < g.width; x += 2) {
            const auto at = [&](int dx, int dy) { return g.label[size_t(y + dy) * size_t(g.width) + size_t(x + dx)]; };
            const truth::Label a = at(0, 0), b = upwards ? at(0, 1) : at(1, 0);
            const auto valid = [](truth::Label label) { return label == truth::Label::lit || label == truth::Label::shadowed; };
            if (!valid(a) || !valid(b)) continue;
            ++both;
            differing += a != b;
        }
    return double(differing) / double(both);
}

TEST(HalfPixelSensitivity, IsWhatPicturesOfTwiceTheResolutionSay) {
    for (const auto& [scene, view] : {std::pair("forest-small", "above"), {"forest-small", "walk2"}, {"box", "front"}}) {
        const auto coarse = workbench().sharedFrame(spec(scene, view, 320, 240)), fine = workbench().sharedFrame(spec(scene, view, 640, 480));
        const truth::Reference& g = fine->reference();
        const double expected = (differingPairs(g, false) + differingPairs(g, true)) / 2;
        EXPECT_NEAR(coarse->halfPixelSensitivity(), expected, 0.15 * expected + 2e-4) << scene << " " << view;
        // The camera stands as before.
        EXPECT_EQ(coarse->frame.camera().shift, glm::dvec2(0, 0));
    }
}

}  // namespace
}  // namespace dapple::bench
