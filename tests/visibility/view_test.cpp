#include "visibility/view.h"

#include "base/random.h"
#include "visibility/views.h"

#include <gtest/gtest.h>

namespace dapple::visibility {
namespace {

constexpr int kWidth = 640, kHeight = 480;

struct Kind {
    const char* name;
    double warp;  // < 0: a camera
};
const Kind kKinds[] = {{"camera", -1}, {"orthographic", 0}, {"warped", 0.9}};

CullView randomView(const Kind& kind, base::Random& random) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, -0.1f)));
    if (kind.warp < 0) return CullView::camera({1, 2, 3}, cameraMatrix(direction, random.next(0.2f, 1.5f), random.next(0.2f, 1.5f), 0.1, 500), 0.1);
    return CullView::sun({1, 2, 3}, sunMatrix(direction, random.next(5, 200), -100, 300, kind.warp), direction);
}

base::DBox randomBox(base::Random& random) {
    const glm::dvec3 at(random.next(-150, 150), random.next(-150, 150), random.next(-150, 150));
    const double scale = std::pow(10.0, double(random.next(-2, 1.7f)));
    return {at, at + scale * glm::dvec3(random.next(), random.next(), random.next())};
}
glm::dvec3 randomPoint(const base::DBox& box, base::Random& random) { return box.lo + box.size() * glm::dvec3(random.next(), random.next(), random.next()); }

glm::dvec4 clip(const CullView& view, const glm::dvec3& p) { return view.clipFromRelative * glm::dvec4(p, 1); }
glm::dvec2 pixel(const CullView& view, const glm::dvec3& p) {
    const glm::dvec4 c = clip(view, p);
    return {c.x / c.w * kWidth / 2, c.y / c.w * kHeight / 2};
}

// A step of `footprint` across the rays moves the image by a pixel at least, in whatever direction the pixel lies.
TEST(CullView, FootprintIsThatOfTheLongestPixel) {
    for (const Kind& kind : kKinds) {
        base::Random random(1, 0, 0);
        int tested = 0;
        double tightest = 1e300;
        for (int i = 0; i < 3000; ++i) {
            const CullView view = randomView(kind, random);
            const base::DBox box = randomBox(random);
            if (!view.mayContain(box) || view.certainlyVisible(box)) continue;
            const double bound = view.footprint(box, kWidth, kHeight);
            for (int k = 0; k < 20; ++k) {
                const glm::dvec3 p = randomPoint(box, random);
                const glm::dvec4 c = clip(view, p);
                if (std::abs(c.x) > c.w || std::abs(c.y) > c.w) continue;  // off the raster: no sample
                // A small step on the plane across the axis, from finite differences.
                glm::dvec3 a = glm::normalize(glm::cross(view.axis, glm::dvec3(0.3, 0.5, 0.8))), b = glm::cross(view.axis, a);
                const double h = 1e-4 * bound, angle = random.next(0, 6.28f);
                const glm::dvec2 step = (pixel(view, p + (a * std::cos(angle) + b * std::sin(angle)) * h) - pixel(view, p)) / h;
                ASSERT_GE(glm::length(step) * bound, 1 - 1e-3) << kind.name;
                tightest = std::min(tightest, glm::length(step) * bound);
                ++tested;
            }
        }
        EXPECT_GT(tested, 1000) << kind.name;
        EXPECT_LT(tightest, 1.01) << kind.name;  // and no longer than that
    }
}

TEST(CullView, NoPointThatIsSeenLiesInACulledBox) {
    for (const Kind& kind : kKinds) {
        base::Random random(2, 0, 0);
        int seen = 0, culled = 0;
        for (int i = 0; i < 20000; ++i) {
            const CullView view = randomView(kind, random);
            const base::DBox box = randomBox(random);
            const bool kept = view.mayContain(box);
            culled += !kept;
            const glm::dvec4 c = clip(view, randomPoint(box, random));
            const bool in = std::abs(c.x) <= c.w && std::abs(c.y) <= c.w && c.z <= c.w && (kind.warp >= 0 || c.z >= 0);
            seen += in;
            ASSERT_TRUE(kept || !in) << kind.name;
        }
        EXPECT_GT(seen, 100) << kind.name;
        EXPECT_GT(culled, 1000) << kind.name;
    }
    EXPECT_FALSE(CullView::sun({0, 0, 0}, sunMatrix({0, 0, -1}, 5, 0, 1), {0, 0, -1}).mayContain({}));
}

TEST(CullView, KeyIsThatOfTheNearestPoint) {
    base::Random random(3, 0, 0);
    for (int i = 0; i < 500; ++i) {
        const CullView camera = randomView(kKinds[0], random), sun = randomView(kKinds[1], random);
        const base::DBox box = randomBox(random);
        double alongSun = 1e300;
        for (int c = 0; c < 8; ++c) alongSun = std::min(alongSun, glm::dot(sun.axis, box.corner(c)));
        EXPECT_NEAR(sun.key(box), alongSun, 1e-9);
        for (int k = 0; k < 20; ++k) EXPECT_LE(camera.key(box), glm::length(randomPoint(box, random)));
    }
    EXPECT_DOUBLE_EQ(randomView(kKinds[0], random).key({{3, -1, 4}, {9, 1, 8}}), 5);
    EXPECT_DOUBLE_EQ(randomView(kKinds[0], random).key({{-1, -1, -1}, {1, 1, 1}}), 0);
}

// A query's box must be before the view with all its corners: whatever is not is visible.
TEST(CullView, WhatIsNotSafelyBeforeTheViewIsVisible) {
    const CullView camera = CullView::camera({0, 0, 0}, cameraMatrix({0, 1, 0}, 1, 1, 0.5, 100), 0.5);
    const auto boxAt = [](double x, double y) { return base::DBox{glm::dvec3(x - 0.1, y - 0.1, -0.1), glm::dvec3(x + 0.1, y + 0.1, 0.1)}; };
    EXPECT_TRUE(camera.certainlyVisible(boxAt(0, 0)));                    // holds the eye
    EXPECT_TRUE(camera.certainlyVisible(boxAt(0, 0.5)));                  // cut by the near plane
    EXPECT_TRUE(camera.certainlyVisible({{-9, -9, -9}, {9, 99, -0.4}}));  // reaches behind the eye
    EXPECT_FALSE(camera.certainlyVisible(boxAt(0, 0.7)));
    EXPECT_FALSE(camera.certainlyVisible(boxAt(30, 50)));
    const CullView ortho = CullView::sun({0, 0, 0}, sunMatrix({0, 0, -1}, 10, 0, 10), {0, 0, -1});
    EXPECT_FALSE(ortho.certainlyVisible({{-99, -99, -99}, {99, 99, 99}}));  // depth clamp
    base::Random random(4, 0, 0);
    int visible = 0;
    for (int i = 0; i < 5000; ++i) {
        const CullView warped = randomView({"warped", 0.9}, random);
        const base::DBox box = randomBox(random);
        double least = 1e300;
        for (int c = 0; c < 8; ++c) least = std::min(least, clip(warped, box.corner(c)).w);
        if (least <= 0) { ASSERT_TRUE(warped.certainlyVisible(box)); }
        visible += least <= 0;
    }
    EXPECT_GT(visible, 100);
}

}  // namespace
}  // namespace dapple::visibility
