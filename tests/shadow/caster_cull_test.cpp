#include "shadow/map/caster_cull.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::shadow {
namespace {

const base::DBox kWorld{{-100, -100, -2}, {100, 100, 20}};

frame::Camera cameraAlong(const glm::dvec3& forward) {
    scenegen::View view;
    view.forward = glm::normalize(forward);
    view.up = {0, 0, 1};
    view.near = 0.3;
    view.far = 80;
    return frame::Camera(view, 4, 3);
}

/// Does the ray p + t l, t >= 0, meet the frustum within kWorld? Clipped against all planes.
bool rayMeetsBody(const frame::Camera& camera, const glm::dvec3& p, const glm::dvec3& l) {
    double enter = 0, leave = 1e9;
    const auto clip = [&](const glm::dvec3& normal, double w) {
        const double at = glm::dot(normal, p) + w, speed = glm::dot(normal, l);
        if (speed > 0) enter = std::max(enter, -at / speed);
        else if (speed < 0) leave = std::min(leave, -at / speed);
        else if (at < 0) leave = -1;
    };
    for (const glm::dvec4& plane : camera.planes()) clip(glm::dvec3(plane), plane.w);
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 e(0);
        e[axis] = 1;
        clip(e, -kWorld.lo[axis]);
        clip(-e, kWorld.hi[axis]);
    }
    return enter <= leave;
}

class CasterCullTest : public testing::TestWithParam<glm::dvec3> {};
INSTANTIATE_TEST_SUITE_P(Suns, CasterCullTest,
                         testing::Values(glm::dvec3(0, 0, -1), glm::dvec3(1, 0.3, -1), glm::dvec3(-1, 1, -1), glm::dvec3(-1, -1, -0.05),
                                         glm::dvec3(0, 1, -0.2), glm::dvec3(0.2, -1, -0.1)));

// Oracle: rays from many points of each box. Whatever one of them finds must be kept; what none finds is mostly dropped.
TEST_P(CasterCullTest, KeepsEveryCasterThatMattersAndFewOthers) {
    const glm::dvec3 l = glm::normalize(GetParam());
    for (const glm::dvec3 forward : {glm::dvec3(0.2, 1, -0.1), glm::dvec3(1, 0, 0), glm::dvec3(-0.3, -0.2, -1)}) {
        const frame::Camera camera = cameraAlong(forward);
        const CasterCull cull(lightBasis(l, camera.forward), camera, viewBody(camera, camera.near, camera.far, kWorld), 0);
        base::Random random(17, 0, 0);
        size_t kept = 0, matter = 0;
        const size_t count = 3000;
        for (size_t i = 0; i < count; ++i) {
            const glm::dvec3 centre(random.next(-110, 110), random.next(-110, 110), random.next(-2, 20)), half(random.next(0.01f, 3), random.next(0.01f, 3), random.next(0.01f, 6));
            bool meets = false;
            for (int k = 0; k < 200 && !meets; ++k) {
                glm::dvec3 p(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1));
                if (k < 8) p = glm::sign(p);
                meets = rayMeetsBody(camera, centre + p * half, l);
            }
            const bool keep = cull.keep({centre - half, centre + half});
            EXPECT_TRUE(keep || !meets);
            kept += keep;
            matter += meets;
        }
        EXPECT_LE(double(kept), 1.05 * double(matter) + 20);
        EXPECT_LT(kept, count / 2);
    }
}

// Oracle: the loop over all boxes, at an eye far from the origin too, where a box rounds as the one that encloses it does not.
TEST_P(CasterCullTest, AHierarchyKeepsWhatALoopKeeps) {
    const glm::dvec3 l = glm::normalize(GetParam());
    base::Random random(5, 0, 0);
    std::vector<base::Box> boxes;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec3 centre(std::round(random.next(-90, 90)), std::round(random.next(-90, 90)), random.next(0, 9)), half(random.next(0, 2));
        boxes.push_back(i % 50 == 0 ? base::Box{} : base::Box{centre - half, centre + half});
    }
    const std::vector<uint32_t> triangles(boxes.size(), 1000);
    for (const glm::dvec3 eye : {glm::dvec3(0), glm::dvec3(17.3, -40, 3), glm::dvec3(1e6 / 3, 0, 1)})
        for (const glm::dvec3 forward : {glm::dvec3(0.2, 1, -0.1), glm::dvec3(-0.3, -0.2, -1)}) {
            std::vector<base::Box> moved = boxes;
            if (eye.x > 1e5)
                for (base::Box& box : moved)
                    if (!box.empty()) box.lo += glm::vec3(eye), box.hi += glm::vec3(eye);
            const gpuscene::Hierarchy hierarchy(moved, triangles, {});
            const frame::Camera camera = cameraAlong(forward);
            const CasterCull cull(lightBasis(l, camera.forward), camera, viewBody(camera, camera.near, camera.far, kWorld), 0.5);
            std::vector<uint32_t> expected;
            for (uint32_t i = 0; i < moved.size(); ++i)
                if (!moved[i].empty() && cull.keep({glm::dvec3(moved[i].lo) - eye, glm::dvec3(moved[i].hi) - eye})) expected.push_back(i);
            EXPECT_EQ(cull.kept(hierarchy, moved, eye), expected);
            EXPECT_GT(expected.size(), 0u);
            EXPECT_LT(expected.size(), 3000u);
        }
}

TEST(CasterCull, TheMarginReachesFurther) {
    const frame::Camera camera = cameraAlong({0, 1, 0});
    const LightBasis basis = lightBasis({0, 0, -1}, camera.forward);
    const auto body = viewBody(camera, camera.near, camera.far, kWorld);
    const base::DBox behind{{-1, -3, 5}, {1, -2, 6}};  // two metres behind the eye, under a sun at the zenith
    EXPECT_FALSE(CasterCull(basis, camera, body, 1).keep(behind));
    EXPECT_TRUE(CasterCull(basis, camera, body, 2.5).keep(behind));
}

TEST(CasterCull, NothingReachesAnEmptyBody) {
    const frame::Camera camera = cameraAlong({0, 1, 0});
    EXPECT_FALSE(CasterCull(lightBasis({0, 0, -1}, camera.forward), camera, {}, 1).keep(kWorld));
}

}  // namespace
}  // namespace dapple::shadow
