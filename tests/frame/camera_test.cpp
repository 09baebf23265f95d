#include "frame/camera.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::frame {
namespace {

/// Cameras of several poses and depth ranges, the stiffest included.
std::vector<Camera> cameras() {
    std::vector<Camera> result;
    for (const auto& [near, far] : {std::pair(0.3, 300.0), std::pair(1e-3, 1e6), std::pair(1.0, 2.0)}) {
        scenegen::View view{"v", {3, -20, 4}, {0, 1, 0}, {0, 0, 1}, 60, near, far};
        result.emplace_back(view, 640, 480);
        view.forward = glm::normalize(glm::dvec3(-0.7, 0.3, -0.6));  // `up` is no longer perpendicular
        view.fovY = 20;
        result.emplace_back(view, 333, 777);
        view.forward = {0, 0, -1};
        view.up = {0, 1, 0};
        view.fovY = 120;
        result.emplace_back(view, 1920, 200);
    }
    return result;
}
std::vector<Camera> shiftedCameras() {
    std::vector<Camera> result = cameras();
    for (Camera& camera : result) camera.shiftBy({0.5, -0.25});
    return result;
}

/// A direction with eye depth 1 somewhere about the frustum; `spread` 1 = just its width.
glm::dvec3 direction(const Camera& camera, base::Random& random, float spread) {
    return camera.forward + camera.right * (camera.tanX * double(random.next(-spread, spread))) +
           camera.up * (camera.tanY * double(random.next(-spread, spread)));
}
/// An eye depth, uniform in its logarithm from 0.3 · near to 3 · far.
double someDepth(const Camera& camera, base::Random& random) {
    return 0.3 * camera.near * std::pow(10 * camera.far / camera.near, double(random.next()));
}

/// Smallest of the six clip-space inequalities (OpenGL 4.5 §13.5, zero-to-one depth): ≥ 0 inside.
std::array<double, 6> clipTests(const Camera& camera, const glm::dvec3& p) {
    const glm::dvec4 c = camera.clipFromRelative * glm::dvec4(p, 1);
    return {c.w - c.z, c.z, c.w + c.x, c.w - c.x, c.w + c.y, c.w - c.y};
}
bool insideClip(const Camera& camera, const glm::dvec3& p) {
    const auto tests = clipTests(camera, p);
    return *std::min_element(tests.begin(), tests.end()) >= 0;
}

TEST(Camera, AxesAreOrthonormalAndRightHanded) {
    for (const Camera& c : cameras()) {
        EXPECT_NEAR(glm::length(c.right), 1, 1e-15);
        EXPECT_NEAR(glm::length(c.up), 1, 1e-15);
        EXPECT_NEAR(glm::length(glm::cross(c.right, c.up) + c.forward), 0, 1e-15);  // looks along −z of its own frame
        EXPECT_GE(glm::dot(c.up, glm::abs(c.forward.z) > 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1)), 0);
    }
}

TEST(Camera, AShiftedPictureHasAtAPixelsCentreWhatLiesBesideIt) {
    const Camera camera({"v", {3, -20, 4}, {0.1, 1, -0.2}, {0, 0, 1}, 60, 0.3, 300}, 640, 480);
    for (const glm::dvec2& shift : {glm::dvec2(0.5, 0), glm::dvec2(0, 0.5), glm::dvec2(-1, 2)}) {
        Camera shifted = camera;
        shifted.shiftBy(shift);
        for (const auto& [x, y] : {std::pair(3, 5), {300, 470}}) {
            const glm::dvec3 p = shifted.relativePoint(x, y, 0.01);
            const glm::dvec4 own = shifted.clipFromRelative * glm::dvec4(p, 1), other = camera.clipFromRelative * glm::dvec4(p, 1);
            const glm::dvec2 half(320, 240), centre(x + 0.5, y + 0.5);
            EXPECT_LT(glm::length((glm::dvec2(own) / own.w + 1.0) * half - centre), 1e-9);
            EXPECT_LT(glm::length((glm::dvec2(other) / other.w + 1.0) * half - centre - shift), 1e-9);
            EXPECT_NEAR(own.z / own.w, 0.01, 1e-12);
        }
    }
}

TEST(Camera, DepthIsOneAtNearAndZeroAtFar) {
    for (const Camera& c : cameras()) {
        const auto depthAt = [&](double z) {
            const glm::dvec4 clip = c.clipFromRelative * glm::dvec4(c.forward * z, 1);
            return clip.z / clip.w;
        };
        EXPECT_NEAR(depthAt(c.near), 1, 1e-12);
        EXPECT_NEAR(depthAt(c.far), 0, 1e-12);
        EXPECT_NEAR(c.eyeDepth(1) / c.near, 1, 1e-12);
        EXPECT_NEAR(c.eyeDepth(0) / c.far, 1, 1e-12);
        for (double z = c.near; z < c.far; z *= 1.7) EXPECT_GT(depthAt(z), depthAt(z * 1.01));
    }
}

TEST(Camera, RelativePointUndoesTheProjection) {
    base::Random random(1, 0, 0);
    for (const Camera& c : cameras())
        for (int i = 0; i < 10'000; ++i) {
            // A point on the ray through a pixel's centre, found without the camera's own inverse.
            const int x = int(random.next(0, float(c.width))), y = int(random.next(0, float(c.height)));
            const double z = std::clamp(someDepth(c, random), c.near, c.far);
            const glm::dvec3 p = z * (c.forward + c.right * (c.tanX * ((2.0 * x + 1) / c.width - 1)) + c.up * (c.tanY * ((2.0 * y + 1) / c.height - 1)));
            const glm::dvec4 clip = c.clipFromRelative * glm::dvec4(p, 1);
            ASSERT_NEAR((clip.x / clip.w + 1) / 2 * c.width, x + 0.5, 1e-9 * c.width);  // (0,0) is the lower left pixel
            ASSERT_NEAR((clip.y / clip.w + 1) / 2 * c.height, y + 0.5, 1e-9 * c.height);
            ASSERT_LT(glm::distance(c.relativePoint(x, y, clip.z / clip.w), p), 1e-9 * glm::length(p)) << z;
        }
}

TEST(Camera, PlanesAgreeWithClipSpace) {
    base::Random random(2, 0, 0);
    std::vector<Camera> all = cameras();
    for (const Camera& shifted : shiftedCameras()) all.push_back(shifted);
    for (const Camera& c : all) {
        int inside = 0, tested = 0;
        for (int i = 0; i < 100'000; ++i) {
            const glm::dvec3 p = direction(c, random, 1.5f) * (someDepth(c, random) * (i % 10 == 0 ? -1 : 1));
            const auto clip = clipTests(c, p);
            const auto planes = c.planes();
            for (size_t k = 0; k < 6; ++k) {
                const double distance = glm::dot(glm::dvec3(planes[k]), p) + planes[k].w;
                if (std::abs(distance) < 1e-9 * (glm::length(p) + c.near)) continue;  // rounding decides
                ASSERT_EQ(distance > 0, clip[k] > 0) << k << " " << distance << " " << clip[k];
                ++tested;
            }
            inside += insideClip(c, p);
        }
        EXPECT_GT(tested, 599'000);
        EXPECT_GT(inside, 5'000);  // at least (1 / 1.5²) · ln 2 / ln 20 · 90 % of them, 9 %, lie inside
        EXPECT_LT(inside, 50'000);
        for (const glm::dvec4& plane : c.planes()) EXPECT_NEAR(glm::length(glm::dvec3(plane)), 1, 1e-15);
    }
}

TEST(Camera, MayContainRejectsNoBoxThatHoldsAVisiblePoint) {
    base::Random random(3, 0, 0);
    for (const Camera& c : cameras()) {
        int visible = 0, rejected = 0;
        for (int i = 0; i < 4000; ++i) {
            base::DBox box;
            const double z = someDepth(c, random);
            const glm::dvec3 centre = direction(c, random, 3) * z;
            for (int k = 0; k < 2; ++k)
                box.extend(centre + z * std::pow(0.01, double(random.next())) * glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)));
            const bool kept = c.mayContain(box);
            bool holds = false;
            for (int k = 0; k < 50 && !holds; ++k)
                holds = insideClip(c, glm::mix(box.lo, box.hi, glm::dvec3(random.next(), random.next(), random.next())));
            EXPECT_TRUE(kept || !holds) << i;
            visible += holds;
            rejected += !kept;
        }
        EXPECT_GT(visible, 100);  // neither half of the claim is empty
        EXPECT_GT(rejected, 400);
    }
}

TEST(Camera, MayContainHoldsThinAndHugeBoxes) {
    base::Random random(4, 0, 0);
    for (const Camera& c : cameras()) {
        for (int i = 0; i < 2000; ++i) {
            const double z = std::clamp(someDepth(c, random), c.near * 1.001, c.far * 0.999);
            const glm::dvec3 p = direction(c, random, 0.999f) * z;
            EXPECT_TRUE(c.mayContain({p, p}));
            EXPECT_TRUE(c.mayContain({p, p + glm::dvec3(1e7, 0, 0)}));
        }
        EXPECT_TRUE(c.mayContain({glm::dvec3(-1e8), glm::dvec3(1e8)}));
        EXPECT_FALSE(c.mayContain(base::DBox{}));
    }
}

TEST(Camera, MayContainRejectsWhatLiesOutsideOnePlane) {
    base::Random random(5, 0, 0);
    for (const Camera& c : cameras()) {
        int outside = 0;
        for (int i = 0; i < 4000; ++i) {
            base::DBox box;
            const double z = someDepth(c, random);
            for (int k = 0; k < 3; ++k) box.extend(direction(c, random, 4) * (z * (i % 4 == 0 ? -1 : 1)) + 0.1 * z * glm::dvec3(random.next(), random.next(), random.next()));
            std::array<bool, 6> all;
            all.fill(true);
            for (int corner = 0; corner < 8; ++corner) {
                const auto tests = clipTests(c, box.corner(corner));
                for (size_t k = 0; k < 6; ++k) {
                    // Well outside: the depth planes in metres of clip z's own scale, the sides against w.
                    const double eyeZ = glm::dot(c.forward, box.corner(corner));
                    const double margin = 1e-4 * glm::length(box.corner(corner));
                    all[k] = all[k] && (k == 0 ? eyeZ < c.near - margin : k == 1 ? eyeZ > c.far + margin : tests[k] < -margin / std::min(c.tanX, c.tanY));
                }
            }
            if (std::none_of(all.begin(), all.end(), [](bool b) { return b; })) continue;
            ++outside;
            EXPECT_FALSE(c.mayContain(box)) << i;
        }
        EXPECT_GT(outside, 300);
    }
}

}  // namespace
}  // namespace dapple::frame
