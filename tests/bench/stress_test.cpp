#include "bench/stress.h"

#include "bench/fixture.h"

#include <numbers>

namespace dapple::bench {
namespace {

scenegen::Scene plane() {
    scenegen::Scene scene;
    scene.name = "plane";
    scene.materials.resize(1);
    scenegen::Mesh mesh;
    mesh.positions = {{-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 3}};
    mesh.normals.assign(4, {0, 0, 1});
    mesh.indices = {0, 1, 2, 0, 2, 3};
    scene.prototypes.resize(1);
    scene.prototypes[0].meshes.push_back(mesh);
    scene.instances.resize(1);
    scene.views.resize(2);
    scene.views[1].forward = {1, 0, 0};
    return scene;
}

double angleToLight(const scenegen::Scene& scene, const scenegen::View& view) {
    return std::atan2(glm::length(glm::cross(view.forward, scene.sun.direction())), glm::dot(view.forward, scene.sun.direction()));
}

TEST(Stress, EveryCaseKeepsTheSceneValid) {
    for (const StressCase& c : stressCases()) {
        scenegen::Scene scene = plane();
        c.apply(scene);
        scenegen::dropBadInstances(scene);
        EXPECT_NO_THROW(scenegen::validate(scene)) << c.name;
        for (const scenegen::View& view : scene.views) {
            EXPECT_NEAR(glm::length(view.forward), 1, 1e-12) << c.name;
            EXPECT_NEAR(glm::length(view.up), 1, 1e-12) << c.name;
            EXPECT_LT(std::abs(glm::dot(view.forward, view.up)), 0.999) << c.name;
            EXPECT_LT(view.near, view.far);
        }
        EXPECT_EQ(&stressCase(c.name), &c);
        const bool changes = scene.contentHash() != plane().contentHash();
        EXPECT_EQ(changes, c.name != "none" && c.name != "bad-instances") << c.name;
    }
    EXPECT_NE(messageOf([] { stressCase("dueling"); }).find("'duelling'"), std::string::npos);
}

TEST(Stress, AnglesAreWhatTheNamesSay) {
    const auto expect = [](const char* name, double radians, double tolerance) {
        scenegen::Scene scene = plane();
        stressCase(name).apply(scene);
        for (const scenegen::View& view : scene.views) EXPECT_NEAR(angleToLight(scene, view), radians, tolerance) << name;
    };
    expect("parallel-0", 0, 1e-15);
    expect("parallel-1e-7", 1e-7, 1e-12);
    expect("parallel-1e-3", 1e-3, 1e-12);
    expect("duelling", std::numbers::pi, 1e-12);

    scenegen::Scene zenith = plane();
    stressCase("sun-zenith").apply(zenith);
    EXPECT_NEAR(zenith.sun.direction().z, -1, 1e-12);
    scenegen::Scene below = plane();
    stressCase("sun-below").apply(below);
    EXPECT_LT(below.sun.elevation, 0);
}

TEST(Stress, NothingCastsOrNothingIsSeen) {
    scenegen::Scene scene = plane();
    stressCase("no-caster").apply(scene);
    EXPECT_FALSE(scene.facts().casters);
    scene = plane();
    stressCase("no-receiver").apply(scene);
    for (const scenegen::View& view : scene.views) {
        EXPECT_GT(view.eye.z, scene.facts().box.hi.z);
        // Half the diagonal field of view stays above the horizontal.
        EXPECT_GT(view.forward.z, std::sin(0.5 * view.fovY * std::numbers::pi / 180));
    }
}

TEST(Stress, BadInstancesAreDroppedAndCountedAndTheRestStays) {
    scenegen::Scene scene = plane();
    for (int i = 1; i < 6; ++i) {
        scene.instances.push_back(scene.instances.front());
        scene.instances.back().translation.x = float(i);
    }
    scene.motions = {{1, {1, 0, 0}, {2, 0, 0}, 1, 0}, {4, {4, 0, 0}, {5, 0, 0}, 1, 0}};
    const scenegen::Scene before = scene;
    stressCase("bad-instances").apply(scene);
    EXPECT_EQ(scene.instances.size(), 13u);
    EXPECT_FALSE(messageOf([&] { scenegen::validate(scene); }).empty());
    scenegen::dropBadInstances(scene);
    EXPECT_EQ(scene.contentHash(), before.contentHash());
    ASSERT_EQ(scene.dropped.size(), 7u);
    EXPECT_NE(scene.dropped[0].find("instance 0"), std::string::npos);
    EXPECT_NE(scene.dropped[2].find("scale is 0"), std::string::npos);
    EXPECT_NE(scene.dropped[3].find("scale is -1"), std::string::npos);
    for (const scenegen::Motion& m : scene.motions) EXPECT_EQ(scene.instances[m.instance].translation.x, m.from.x);
}

TEST(Stress, TheMotionOfABadInstanceGoesWithIt) {
    scenegen::Scene scene = plane();
    scene.instances.resize(2);
    scene.instances[0].scale = -2;
    scene.motions = {{0, {0, 0, 0}, {1, 0, 0}, 1, 0}, {1, {0, 0, 0}, {1, 0, 0}, 2, 0}};
    scenegen::dropBadInstances(scene);
    ASSERT_EQ(scene.motions.size(), 1u);
    EXPECT_EQ(scene.motions[0].instance, 0u);
    EXPECT_EQ(scene.motions[0].speed, 2);
}

}  // namespace
}  // namespace dapple::bench
