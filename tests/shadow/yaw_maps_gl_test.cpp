// Instanced maps at the yaws that a scene has: where they are few, each has its map, and the picture is that of a map for every
// instance; own maps go to the others. A caster too large for a map of its own goes to the far field.
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/renderer.h"
#include "truth/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::shadow {
namespace {

scenegen::Mesh boxMesh(glm::vec3 lo, glm::vec3 hi) {
    scenegen::Mesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const bool upper : {false, true}) {
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            const auto first = uint32_t(mesh.positions.size());
            for (const auto& [u, v] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
                glm::vec3 p, n(0);
                p[axis] = upper ? hi[axis] : lo[axis];
                p[a] = u ? hi[a] : lo[a];
                p[b] = v ? hi[b] : lo[b];
                n[axis] = upper ? 1.f : -1.f;
                mesh.positions.push_back(p);
                mesh.normals.push_back(n);
            }
            for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + (upper ? k : (4 - k) % 4));
        }
    return mesh;
}

/// A ground of 400 m, and a prototype to stand on it.
scenegen::Scene town(const char* name, scenegen::Prototype prototype) {
    scenegen::Scene scene;
    scene.name = name;
    scene.materials.push_back({});
    scene.prototypes.push_back({"ground", {boxMesh({-200, -200, -1}, {200, 200, 0})}, false});
    scene.prototypes.push_back(std::move(prototype));
    scene.instances.push_back({});
    scene.sun = {100, 35};
    const auto toward = [](glm::dvec3 eye, glm::dvec3 at) { return glm::normalize(at - eye); };
    scene.views = {{"street", {-70, -40, 2}, toward({-70, -40, 2}, {20, 20, 6}), {0, 0, 1}, 60, 0.3, 500},
                   {"above", {-120, -120, 90}, toward({-120, -120, 90}, {0, 0, 0}), {0, 0, 1}, 60, 1, 800}};
    return scene;
}

/// 36 towers, twice as long as wide, whose yaws lie in the middle between steps of 30°.
scenegen::Scene towers() {
    scenegen::Scene scene = town("towers", {"tower", {boxMesh({-6, -2.5f, 0}, {6, 2.5f, 20})}});
    const float yaws[] = {45, 135, -45, -135};
    for (int i = 0; i < 36; ++i) scene.instances.push_back({{-75 + 30 * float(i % 6), -75 + 30 * float(i / 6), 0}, 1, glm::radians(yaws[i % 4]), 1});
    return scene;
}

/// Rows of houses as one mesh.
scenegen::Scene quarter() {
    scenegen::Prototype houses{"quarter", {}};
    for (int x = -9; x <= 9; ++x)
        for (int y = -9; y <= 9; ++y)
            houses.meshes.push_back(boxMesh({20 * x - 4, 20 * y - 4, 0}, {20 * x + 4, 20 * y + 4, 6 + float((x * x + y) % 5)}));
    scenegen::Scene scene = town("quarter", std::move(houses));
    scene.instances.push_back({{0, 0, 0}, 1, 0, 1});
    return scene;
}

class YawMaps : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);

    struct Image {
        std::vector<float> visibility;
        double error = 0;
        size_t texels = 0;
        std::string note;
    };
    static Image render(frame::Frame& frame, const scenegen::Scene& scene, const char* name, const Settings& axes = {}) {
        Renderer renderer(frame, technique(name), resolve(technique(name), axes));
        frame::PassObserver silent;
        renderer.render(silent);
        const truth::Reference truth = truth::Tracer(scene).trace(frame.readReceivers(), frame.camera().eye, frame.light());
        Image image{renderer.visibility(), 0, renderer.technique() ? renderer.technique()->texelsInUse() : 0, renderer.fallback()};
        image.error = truth::measureError(truth, image.visibility).error;
        return image;
    }
};

TEST_F(YawMaps, FewYawsAreAsExactAsAMapForEveryInstance) {
    const scenegen::Scene scene = towers();
    const gpuscene::GpuScene gpu(scene);
    for (const scenegen::View& view : scene.views) {
        SCOPED_TRACE(view.name);
        frame::Frame frame(gpu, view, 160, 120);
        const Image exact = render(frame, scene, "instanced", {{"mode", "exact"}}), twelve = render(frame, scene, "instanced"), near = render(frame, scene, "instanced-near");
        EXPECT_EQ(twelve.visibility, exact.visibility);
        EXPECT_EQ(twelve.texels, 4u * 512 * 512) << "four yaws";
        EXPECT_EQ(exact.texels, 36u * 512 * 512);
        EXPECT_EQ(near.visibility, exact.visibility);
        EXPECT_EQ(near.texels, twelve.texels) << "no instance needs a map of its own";
        EXPECT_EQ(render(frame, scene, "instanced", {{"rotations", "4"}}).visibility, exact.visibility);
        // What steps between the yaws cost: three maps are too few.
        const Image three = render(frame, scene, "instanced", {{"rotations", "3"}});
        EXPECT_EQ(three.texels, 3u * 512 * 512);
        EXPECT_GT(three.error, 8 * exact.error);
        EXPECT_LT(exact.error, 0.005);
    }
}

// Own maps beside shared ones: of 16 oaks on a ring of 12, and 8 firs with a map each, only oaks get one.
TEST_F(YawMaps, OwnMapsImproveTheInstancesThatNeedThem) {
    const scenegen::Scene scene = scenegen::loadScene("forest-small");
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), 160, 120);
    const Image shared = render(frame, scene, "instanced"), near = render(frame, scene, "instanced-near"), all = render(frame, scene, "instanced", {{"own", "16"}});
    EXPECT_EQ(shared.texels, (12u + 8) * 512 * 512);
    EXPECT_EQ(near.texels, (12u + 8 + 12) * 512 * 512);
    EXPECT_LT(near.error, shared.error / 2);
    // With as many as there are oaks, the picture is that of mode exact.
    EXPECT_EQ(all.visibility, render(frame, scene, "instanced", {{"mode", "exact"}}).visibility);
    EXPECT_EQ(render(frame, scene, "instanced", {{"own", "100"}}).texels, all.texels);
}

TEST_F(YawMaps, AQuarterInOnePieceGoesToTheFarField) {
    const scenegen::Scene scene = quarter();
    const gpuscene::GpuScene gpu(scene);
    for (const scenegen::View& view : scene.views) {
        SCOPED_TRACE(view.name);
        frame::Frame frame(gpu, view, 160, 120);
        const Image instanced = render(frame, scene, "instanced"), cascaded = render(frame, scene, "cascaded"), none = render(frame, scene, "unshadowed");
        EXPECT_NE(instanced.note.find("instanced → cascaded for 1 of 1 casters"), std::string::npos) << instanced.note;
        EXPECT_EQ(instanced.visibility, cascaded.visibility);
        EXPECT_LT(instanced.error, none.error / 4);
        // What its own map would show, where nothing else can.
        const Image own = render(frame, scene, "instanced", {{"apply", "tiled"}});
        EXPECT_EQ(own.note, "");
        EXPECT_GT(own.error, instanced.error);
    }
}

// Under a bound no caster is lost: its map is smaller, or it is drawn into the far field's.
TEST_F(YawMaps, LessMemoryCostsTexelsAndNoShadow) {
    const scenegen::Scene scene = scenegen::loadScene("city-vienna", {"scale=0.15"});
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[scene.viewIndex("above")], 160, 120);
    const double none = render(frame, scene, "unshadowed").error;
    const Image full = render(frame, scene, "instanced", {{"memory", "4096"}}), smaller = render(frame, scene, "instanced", {{"memory", "32"}}), least = render(frame, scene, "instanced", {{"memory", "1"}});
    EXPECT_LE(smaller.texels, (32u << 20) / 4);
    EXPECT_EQ(full.note, "");
    EXPECT_LT(full.error, smaller.error);
    EXPECT_LT(smaller.error, none);
    EXPECT_NE(smaller.note.find("texels a side"), std::string::npos) << smaller.note;
    EXPECT_LT(least.error, none);
    EXPECT_GT(least.error, smaller.error);
}

// A view that turns brings casters into reach that had no map: they get one.
TEST_F(YawMaps, MapsFollowTheView) {
    const scenegen::Scene scene = scenegen::loadScene("city-vienna", {"scale=0.15"});
    const gpuscene::GpuScene gpu(scene);
    scenegen::View view = scene.views.front(), behind = view;
    behind.forward = -view.forward;
    const Settings settings = resolve(technique("instanced"), {{"size", "128"}, {"memory", "8"}});
    frame::PassObserver silent;
    frame::Frame frame(gpu, view, 160, 120);
    Renderer turning(frame, technique("instanced"), settings);
    turning.render(silent);
    ASSERT_NE(turning.fallback().find("cannot reach this view"), std::string::npos);
    frame.look(behind);
    turning.replan();
    turning.render(silent);
    const std::vector<float> turned = turning.visibility();
    frame::Frame other(gpu, behind, 160, 120);
    Renderer fresh(other, technique("instanced"), settings);
    fresh.render(silent);
    EXPECT_GT(std::ranges::count(turned, 0.0f), 1000);
    EXPECT_EQ(turned, fresh.visibility());
}

}  // namespace
}  // namespace dapple::shadow
