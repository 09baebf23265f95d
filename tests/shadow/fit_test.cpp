#include "shadow/map/fit.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::shadow {
namespace {

scenegen::View viewAlong(const glm::dvec3& forward, double near, double far) {
    scenegen::View view;
    view.forward = glm::normalize(forward);
    view.up = std::abs(view.forward.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    view.near = near;
    view.far = far;
    return view;
}

glm::dvec3 project(const glm::dmat4& m, const glm::dvec3& p) {
    const glm::dvec4 q = m * glm::dvec4(p, 1);
    return glm::dvec3(q) / q.w;
}

bool inside(const frame::Camera& camera, const base::DBox& box, const glm::dvec3& p) {
    for (const glm::dvec4& plane : camera.planes())
        if (glm::dot(glm::dvec3(plane), p) + plane.w < 0) return false;
    return glm::all(glm::greaterThanEqual(p, box.lo)) && glm::all(glm::lessThanEqual(p, box.hi));
}

const base::DBox kWorld{{-100, -100, -2}, {100, 100, 20}};

std::vector<glm::dvec3> pointsInView(const frame::Camera& camera, const base::DBox& box, size_t count) {
    base::Random random(11, 0, 0);
    std::vector<glm::dvec3> points;
    for (int tries = 0; points.size() < count && tries < 4'000'000; ++tries) {
        const glm::dvec3 t(random.next(), random.next(), random.next());
        const glm::dvec3 p = box.lo + t * box.size();
        if (inside(camera, box, p)) points.push_back(p);
    }
    return points;
}

TEST(LightBasis, IsOrthonormalAndRightHandedForEveryLight) {
    base::Random random(1, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        glm::dvec3 l = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)));
        glm::dvec3 v = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)));
        if (i % 10 == 0) v = l;
        if (i % 10 == 1) v = -l;
        if (i % 10 == 2) l = {0, 0, -1};
        const LightBasis b = lightBasis(l, v);
        EXPECT_NEAR(glm::length(b.u), 1, 1e-12);
        EXPECT_NEAR(glm::length(b.v), 1, 1e-12);
        EXPECT_NEAR(glm::dot(b.u, b.v), 0, 1e-12);
        EXPECT_NEAR(glm::dot(b.v, b.l), 0, 1e-12);
        EXPECT_NEAR(glm::dot(glm::cross(b.u, b.v), -b.l), 1, 1e-12);  // looking along l: u right, v up
    }
}

TEST(ViewBody, HoldsEveryVisiblePointAndNoMore) {
    for (const glm::dvec3 forward : {glm::dvec3(0, 1, 0), glm::dvec3(1, 1, -0.3), glm::dvec3(0.1, 0, -1)}) {
        const frame::Camera camera(viewAlong(forward, 0.3, 60), 4, 3);
        const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, kWorld);
        const std::vector<glm::dvec3> points = pointsInView(camera, kWorld, 20000);
        ASSERT_GT(points.size(), 20u);
        base::Random random(5, 0, 0);
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 axis = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)));
            double bodyMax = -1e300, pointMax = -1e300;
            for (const glm::dvec3& p : body) bodyMax = std::max(bodyMax, glm::dot(axis, p));
            for (const glm::dvec3& p : points) pointMax = std::max(pointMax, glm::dot(axis, p));
            EXPECT_GE(bodyMax, pointMax - 1e-9);
        }
        for (const glm::dvec3& p : body) {  // and no vertex lies outside, but for rounding
            for (const glm::dvec4& plane : camera.planes()) EXPECT_GE(glm::dot(glm::dvec3(plane), p) + plane.w, -1e-6);
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(p, kWorld.lo - 1e-6)) && glm::all(glm::lessThanEqual(p, kWorld.hi + 1e-6)));
        }
    }
}

TEST(ViewBody, EmptyWhereTheViewMissesTheScene) {
    const frame::Camera camera(viewAlong({0, 0, 1}, 30, 300), 4, 3);
    EXPECT_TRUE(viewBody(camera, camera.near, camera.far, kWorld).empty());
}

TEST(VisibleBody, HoldsWhatIsSeenOfTheBoxesAndNoMore) {
    const frame::Camera camera(viewAlong({0.3, 1, -0.1}, 0.3, 60), 4, 3);
    const double near = 5, far = 45;
    const std::vector<base::DBox> boxes{{{-2, 10, -2}, {3, 14, 4}},      // whole
                                        {{-30, 20, -2}, {30, 24, 1}},    // across both sides
                                        {{-100, -100, -2}, {100, 100, -1.5}},
                                        {{5, 40, 0}, {9, 60, 3}},        // across the far end of the slice
                                        {{0, -9, 0}, {2, -5, 2}},        // behind
                                        {}};
    const std::vector<glm::dvec3> body = visibleBody(camera, near, far, boxes);
    const auto inSlice = [&](const glm::dvec3& p) { return glm::dot(p, camera.forward) >= near && glm::dot(p, camera.forward) <= far; };
    std::vector<glm::dvec3> points;
    for (const base::DBox& box : boxes)
        if (!box.empty())
            for (const glm::dvec3& p : pointsInView(camera, box, 2000))
                if (inSlice(p)) points.push_back(p);
    ASSERT_GT(points.size(), 4000u);
    base::Random random(6, 0, 0);
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 axis = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)));
        double bodyMax = -1e300, pointMax = -1e300;
        for (const glm::dvec3& p : body) bodyMax = std::max(bodyMax, glm::dot(axis, p));
        for (const glm::dvec3& p : points) pointMax = std::max(pointMax, glm::dot(axis, p));
        EXPECT_GE(bodyMax, pointMax - 1e-9);
    }
    for (const glm::dvec3& p : body) {
        for (const glm::dvec4& plane : camera.planes()) EXPECT_GE(glm::dot(glm::dvec3(plane), p) + plane.w, -1e-6);
        EXPECT_GE(glm::dot(p, camera.forward), near - 1e-6);
        EXPECT_LE(glm::dot(p, camera.forward), far + 1e-6);
        EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const base::DBox& box) {
            return glm::all(glm::greaterThanEqual(p, box.lo - 1e-6)) && glm::all(glm::lessThanEqual(p, box.hi + 1e-6));
        }));
    }
}

TEST(FitLight, EveryVisiblePointIsInTheMap) {
    for (const FitKind kind : {FitKind::scene, FitKind::frustum, FitKind::lispsm})
        for (const glm::dvec3 light : {glm::dvec3(0, 0, -1), glm::dvec3(1, 1, -1), glm::dvec3(0.2, -1, -0.1), glm::dvec3(0, 1, -0.001), glm::dvec3(0, -1, -0.02)}) {
            const frame::Camera camera(viewAlong({0, 1, -0.05}, 0.3, 300), 4, 3);
            const glm::dvec3 l = glm::normalize(light);
            const LightBasis basis = lightBasis(l, camera.forward);
            const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, kWorld);
            base::DBox bounds;
            for (int i = 0; i < 8; ++i) bounds.extend(basis.toLight(kWorld.corner(i)));
            const LightFit fit = fitLight(kind, basis, camera, body, bounds, 512, 2);
            ASSERT_FALSE(fit.empty);
            ASSERT_TRUE(base::allFinite(fit.clipFromRelative));
            for (const glm::dvec3& p : pointsInView(camera, kWorld, 3000)) {
                const glm::dvec3 q = project(fit.clipFromRelative, p);
                EXPECT_LE(std::max(std::abs(q.x), std::abs(q.y)), 1 - 2 * 2.0 / 512 + 1e-9);  // the pad stays free
                EXPECT_GE(q.z, 0);
                EXPECT_LE(q.z, 1);
            }
        }
}

// Along a texel's line of light, map depth must grow away from the sun, under the warp too.
TEST(FitLight, DepthOrderIsTheLights) {
    const frame::Camera camera(viewAlong({0, 1, 0}, 0.3, 300), 4, 3);
    const glm::dvec3 l = glm::normalize(glm::dvec3(0.3, 0.2, -1));
    const LightBasis basis = lightBasis(l, camera.forward);
    const auto body = viewBody(camera, camera.near, camera.far, kWorld);
    const LightFit fit = fitLight(FitKind::lispsm, basis, camera, body, {}, 1024, 2);
    ASSERT_EQ(fit.fallback, "");
    for (const glm::dvec3& p : pointsInView(camera, kWorld, 500)) {
        const glm::dvec3 a = project(fit.clipFromRelative, p), b = project(fit.clipFromRelative, p + 0.5 * l);
        EXPECT_NEAR(a.x, b.x, 1e-9);
        EXPECT_NEAR(a.y, b.y, 1e-9);
        EXPECT_LT(a.z, b.z);
    }
}

// The error model of perspective warps (Lloyd et al. 2006): for light perpendicular to the view and depths z₀ … r z₀, the
// texel's footprint along the view, over z, is largest at both ends and equal there, √r − 1/√r times the footprint of
// one texel per unit of the logarithmic ideal.
TEST(LispSm, ReachesTheTheoreticalMaximumError) {
    for (const double r : {6.0, 100.0, 1000.0}) {
        // A slab of ground straight ahead: y from z0 to r z0, seen by a camera whose near plane is z0.
        const double z0 = 1;
        const base::DBox slab{{-0.4 * z0, z0, -0.001}, {0.4 * z0, r * z0, 0.001}};
        const frame::Camera camera(viewAlong({0, 1, 0}, z0 * 0.999, 10 * r), 1, 1);
        const LightBasis basis = lightBasis({0, 0, -1}, camera.forward);
        const auto body = viewBody(camera, camera.near, camera.far, slab);
        ASSERT_FALSE(body.empty());
        const LightFit fit = fitLight(FitKind::lispsm, basis, camera, body, {}, 1 << 20, 0);
        ASSERT_EQ(fit.fallback, "");
        double greatest = 0;
        for (int i = 0; i <= 2000; ++i) {
            const double z = z0 * std::pow(r, i / 2000.0), dz = 1e-5 * z;
            const double slope = (project(fit.clipFromRelative, {0, z + dz, 0}).y - project(fit.clipFromRelative, {0, z - dz, 0}).y) / (4 * dz);
            greatest = std::max(greatest, 1 / slope / z);  // world step per unit of map, over the pixel footprint ∝ z
        }
        EXPECT_NEAR(greatest / (std::sqrt(r) - 1 / std::sqrt(r)), 1, 0.01) << r;
    }
}

TEST(LispSm, FallsBackWhereViewAndLightAreParallel) {
    const frame::Camera camera(viewAlong({0, 0.6, -0.8}, 0.3, 300), 4, 3);
    const auto body = viewBody(camera, camera.near, camera.far, kWorld);
    for (const double angle : {0.0, 1e-7, 1e-3, 0.015}) {
        for (const double sign : {1.0, -1.0}) {
            const glm::dvec3 l = glm::normalize(sign * camera.forward * std::cos(angle) + camera.right * std::sin(angle));
            const LightBasis basis = lightBasis(l, camera.forward);
            const LightFit warped = fitLight(FitKind::lispsm, basis, camera, body, {}, 512, 2);
            const LightFit focused = fitLight(FitKind::frustum, basis, camera, body, {}, 512, 2);
            EXPECT_NE(warped.fallback, "");
            EXPECT_EQ(warped.clipFromRelative, focused.clipFromRelative);
        }
    }
}

TEST(PracticalSplits, RunMonotonouslyFromNearToFar) {
    for (const double lambda : {0.0, 0.5, 0.75, 0.95, 1.0})
        for (int count = 1; count <= 8; ++count) {
            const std::vector<double> s = practicalSplits(0.5, 250, count, lambda);
            ASSERT_EQ(s.size(), size_t(count) + 1);
            EXPECT_DOUBLE_EQ(s.front(), 0.5);
            EXPECT_NEAR(s.back(), 250, 1e-9);
            for (size_t i = 1; i < s.size(); ++i) EXPECT_GT(s[i], s[i - 1]);
            if (count == 1) continue;
            if (lambda == 1.0) {
                EXPECT_NEAR(s[2] / s[1], s[1] / s[0], 1e-9);  // logarithmic: equal ratios
            }
            if (lambda == 0.0) {
                EXPECT_NEAR(s[2] - s[1], s[1] - s[0], 1e-9);  // uniform: equal steps
            }
        }
}

}  // namespace
}  // namespace dapple::shadow
