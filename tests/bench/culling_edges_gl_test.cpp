// Culling where there is nothing to keep, or a box that no projection holds: stated outcomes, and no pixel changed.
#include "bench/walk.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

namespace dapple::bench {
namespace {

constexpr uint32_t kGround = 0, kPost = 1, kRoom = 2, kTower = 3;

/// A ground that casts nothing, posts and towers on it, and a room (its box is hollow to nobody who culls).
scenegen::Scene square(const scenegen::Sun& sun, const std::vector<scenegen::View>& views) {
    scenegen::Scene scene;
    scene.name = "square";
    scene.materials.resize(1);
    scene.prototypes.push_back({"ground", {scenegen::boxMesh({200, 200, 0.5f})}, false, true});
    scene.prototypes.push_back({"post", {scenegen::boxMesh({0.3f, 0.3f, 4})}, true, true});
    scene.prototypes.push_back({"room", {}, true, false});
    for (const float side : {-6.0f, 6.0f}) {  // two walls
        scenegen::Mesh wall = scenegen::boxMesh({0.2f, 12, 5});
        for (glm::vec3& p : wall.positions) p.x += side;
        scene.prototypes.back().meshes.push_back(wall);
    }
    scene.prototypes.push_back({"tower", {scenegen::boxMesh({8, 8, 40})}, true, true});
    scene.instances.push_back({{0, 0, -0.25f}, 1, 0, kGround});
    for (int i = 0; i < 40; ++i) scene.instances.push_back({{float(i % 8) * 9 - 30, float(i / 8) * 11 - 20, 2}, 1, float(i), kPost});
    scene.instances.push_back({{0, 0, 2.5f}, 1, 0.4f, kRoom});
    for (const glm::vec2 at : {glm::vec2(-40, -30), {45, -25}, {5, 60}, {-60, 70}, {4, -35}}) scene.instances.push_back({{at.x, at.y, 20}, 1, at.x, kTower});
    scene.sun = sun;
    scene.views = views;
    return scene;
}

scenegen::View look(const glm::dvec3& eye, const glm::dvec3& forward, double near = 0.3) { return {"look", eye, glm::normalize(forward), std::abs(forward.z) > 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1), 60, near, 300}; }

const char* const kMaps[] = {"uniform", "focused", "lispsm", "cascaded"};

TEST(NoReceiver, NothingIsDrawnForIt) {
    Walk walk(square({200, 40}, {look({0, -15, 30}, {0, 0.1, 1})}));  // the sky
    for (const char* technique : kMaps) {
        expectSamePixels(walk, technique, {});
        for (const shadow::Settings& axes : {shadow::Settings{{"cull", "receivers"}}, {{"cull", "pyramid"}}}) {
            walk.images(technique, axes);
            ASSERT_TRUE(walk.drawn);
            EXPECT_EQ(walk.drawn->instances, 0u) << technique << text(axes);
        }
    }
}

TEST(NoCaster, NothingIsDrawn) {
    scenegen::Scene bare = square({200, 40}, {look({0, -15, 2}, {0, 1, -0.2})});
    bare.instances.resize(1);
    Walk none(bare);
    // Out of reach: beside the view, their shadows fall away from it.
    scenegen::Scene far = square({0, 40}, {look({0, -60, 3}, {0, -1, -0.3})});
    far.instances.resize(1);
    for (const float x : {-70.0f, 70.0f}) far.instances.push_back({{x, 40, 2}, 1, 0, kPost});
    Walk outOfReach(far);
    for (const char* technique : kMaps) {
        expectSamePixels(none, technique, {});
        expectSamePixels(outOfReach, technique, {});
        for (const char* cull : {"frustum", "receivers", "pyramid"}) {
            outOfReach.images(technique, {{"cull", cull}});
            ASSERT_TRUE(outOfReach.drawn);
            EXPECT_EQ(outOfReach.drawn->instances, 0u) << technique << " " << cull;
        }
    }
}

TEST(EyeInABox, NoPixelChanges) {
    // In the room; in a corner of its box, whose faces the near plane cuts; with the near plane through a tower's box.
    Walk walk(square({215, 35}, {look({1, 1, 1.7}, {0.3, 1, 0}), look({-4.9, -4.9, 1}, {1, 0.8, 0}), look({5, -42.5, 2}, {-1, 0.3, 0.02}, 3)}));
    for (const char* technique : kMaps) expectSamePixels(walk, technique, {{"filter", "pcf2"}});
}

TEST(Warped, BoxesBehindTheWarpsOwnEyeAreKept) {
    // The sun stands behind the viewer, low: towers at his back cast into the view.
    Walk walk(square({180, 25}, {look({0, -10, 1.7}, {0, 1, -0.05}), look({2, -5, 20}, {0.2, 1, -0.6})}));
    expectSamePixels(walk, "lispsm", {});
    expectSamePixels(walk, "lispsm", {{"filter", "pcf3"}, {"bias", "constant"}});
    walk.images("lispsm", {});
    ASSERT_EQ(walk.matrices.size(), 1u);
    size_t behind = 0;
    for (uint32_t i = 1; i < walk.scene.instances.size(); ++i)
        for (int corner = 0; corner < 8; ++corner) behind += (walk.matrices[0].clipFromRelative * glm::dvec4(walk.frame.relativeBox(i).corner(corner), 1)).w <= 0;
    EXPECT_GT(behind, 0u) << "no corner with w <= 0: nothing was tested";
}

TEST(LightAlongTheView, NoPixelChanges) {
    const scenegen::Sun sun{200, 30};
    const glm::dvec3 l = sun.direction();
    Walk walk(square(sun, {look({20, 20, 25}, l), look({0, -15, 2}, -l)}));
    for (const char* technique : kMaps) expectSamePixels(walk, technique, {});
    Walk zenith(square({0, 90}, {look({3, 3, 60}, {0, 0, -1}), look({3, 3, 1}, {0, 1, -0.1})}));
    for (const char* technique : kMaps) expectSamePixels(zenith, technique, {});
}

// A map's near plane is that of its receivers, and what is before it is drawn at depth 0: one such caster hides all behind it.
TEST(BeforeTheNearPlane, OneCasterHidesAnother) {
    const scenegen::Sun sun{180, 60};
    const scenegen::View at = look({0, 10, 1.7}, {0, 1, -0.1});
    scenegen::Scene scene = square(sun, {at, at, at, at});
    scene.instances.resize(1);
    scene.prototypes.push_back({"slab", {scenegen::boxMesh({30, 30, 0.2f})}, true, true});
    scene.prototypes.push_back({"crate", {scenegen::boxMesh({3, 3, 3})}, true, true});
    const glm::dvec3 up = -sun.direction();
    scene.instances.push_back({glm::vec3(glm::dvec3(0, 25, 0) + up * 60.0), 1, 0, 4});
    for (int i = 0; i < 30; ++i) scene.instances.push_back({glm::vec3(glm::dvec3(-9 + i % 6 * 3, 16 + i / 6 * 3, 0) + up * 50.0), 1, 0, 5});
    Walk walk(scene);
    expectSamePixels(walk, "focused", {});
    for (const shadow::Settings& axes : {shadow::Settings{{"cull", "chcpp"}, {"leaf", "1"}}, {{"cull", "hiz"}}}) {
        walk.images("focused", axes);
        EXPECT_EQ(walk.drawn->instances, 1u) << text(axes);
    }
}

// Clusters draw an instance's triangles in another order, which may let another of several fragments at one depth win.
TEST(Coplanar, ClustersChangeNoPixel) {
    Walk walk("extreme-coplanar", {});
    const std::vector<shadow::Settings> methods{{{"cull", "frustum"}, {"cluster", "2"}},
                                                {{"cull", "chcpp"}, {"camera", "chcpp"}, {"cluster", "2"}, {"leaf", "4"}},
                                                {{"cull", "receivers"}, {"camera", "chc"}, {"cluster", "2"}, {"leaf", "4"}},
                                                {{"cull", "hiz"}, {"camera", "hiz"}, {"cluster", "2"}},
                                                {{"cull", "pyramid"}, {"camera", "chcpp"}, {"cluster", "2"}}};
    ASSERT_GT(walk.gpu.items(2).size(), 2 * walk.gpu.items().size());
    for (const char* technique : kMaps)
        for (const shadow::Settings& sampling : {shadow::Settings{}, {{"filter", "pcf3"}, {"bias", "normal-offset"}}}) expectSamePixels(walk, technique, sampling, methods);
}

}  // namespace
}  // namespace dapple::bench
