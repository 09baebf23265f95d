#include "frame/overlays.h"

#include <gtest/gtest.h>

namespace dapple::frame {
namespace {

TEST(PaintCandidates, TellsOutsideLitAndShadowedApart) {
    // Black and white pixels of the picture, each outside all volumes, in one and lit, in three and dark, in one and half lit.
    const std::vector<float> volumes{0, 1, 3, 1, 0, 1, 3, 1}, visibility{0, 1, 0, 0.5f, 1, 1, 0, 0.5f};
    base::Image8 shaded{4, 2, 3, std::vector<uint8_t>(12, 0)};
    shaded.texels.resize(24, 255);
    const base::Image8 picture = paintCandidates(shaded, {4, 2, 1, volumes}, visibility);
    ASSERT_EQ(picture.texels.size(), 24u);
    for (size_t i = 0; i < 8; ++i) {
        const int r = picture.texels[3 * i], g = picture.texels[3 * i + 1], b = picture.texels[3 * i + 2];
        SCOPED_TRACE(i);
        if (i % 4 == 0) {  // grey, and darker than half
            EXPECT_EQ(r, g);
            EXPECT_EQ(g, b);
            EXPECT_LE(g, 128);
        } else if (i % 4 == 1) {
            EXPECT_GT(g, 3 * r / 2);
            EXPECT_GT(g, 3 * b / 2);
        } else {
            EXPECT_GT(r, 3 * g);
            EXPECT_GT(r, 3 * b);
        }
        // The picture's own structure stays: each colour is lighter over white than over black.
        if (i < 4) continue;
        EXPECT_GT(r + g + b, picture.texels[3 * i - 12] + picture.texels[3 * i - 11] + picture.texels[3 * i - 10]);
    }
    // Without colour: lit candidates over black are lighter than shadowed ones over white.
    const auto grey = [&](size_t i) { return 0.3 * picture.texels[3 * i] + 0.6 * picture.texels[3 * i + 1] + 0.1 * picture.texels[3 * i + 2]; };
    EXPECT_GT(grey(1), grey(6));
}

}  // namespace
}  // namespace dapple::frame
