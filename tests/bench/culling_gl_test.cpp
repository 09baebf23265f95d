// What culling leaves out must not change a pixel: every method, for every fit, split, filter and bias, along paths that jump.
#include "bench/walk.h"
#include "scenegen/primitives.h"
#include "shadow/map/caster_cull.h"

#include <gtest/gtest.h>

#include <cstring>

namespace dapple::bench {
namespace {

struct TestScene {
    std::string name;
    std::vector<std::string> settings;
};
const TestScene kThree[] = {{"forest-small", {}}, {"city-vienna", {"scale=0.03"}}, {"flythrough", {}}};

class EveryMap : public testing::TestWithParam<std::string> {};

TEST_P(EveryMap, CullingChangesNoPixelWhateverTheSampling) {
    for (const TestScene& scene : kThree) {
        SCOPED_TRACE(scene.name);
        Walk walk(scene.name, scene.settings);
        for (const shadow::Settings& sampling :
             {shadow::Settings{{"filter", "nearest"}}, shadow::Settings{{"filter", "pcf2"}, {"bias", "normal-offset"}}, shadow::Settings{{"filter", "pcf3"}, {"bias", "constant"}, {"size", "100"}}})
            expectSamePixels(walk, GetParam(), sampling);
    }
}
INSTANTIATE_TEST_SUITE_P(Registry, EveryMap, testing::Values("uniform", "focused", "lispsm", "cascaded"), [](const auto& test) { return test.param; });

// Of 2048 texels a side look-ups mark two levels of the pyramid, of 4096 three.
TEST(LargeMaps, ThePyramidChangesNoPixel) {
    for (const TestScene& scene : kThree) {
        SCOPED_TRACE(scene.name);
        Walk walk(scene.name, scene.settings);
        for (const char* size : {"2048", "4096"}) expectSamePixels(walk, "lispsm", {{"filter", "pcf2"}, {"size", size}}, {{{"cull", "pyramid"}}});
    }
}

TEST(EveryScene, CullingChangesNoPixel) {
    const std::vector<shadow::Settings> methods{{{"cull", "chcpp"}}, {{"cull", "receivers"}, {"camera", "chcpp"}}, {{"cull", "hiz"}}, {{"cull", "pyramid"}, {"camera", "hiz"}}, {{"cull", "frustum"}, {"cluster", "20"}}, {{"cull", "pyramid"}, {"camera", "chcpp"}, {"cluster", "100"}, {"leaf", "500"}}};
    bool warped = false;
    for (const scenegen::SceneEntry& entry : scenegen::listScenes()) {
        if (std::ranges::any_of(kThree, [&](const TestScene& three) { return three.name == entry.name; })) continue;
        SCOPED_TRACE(entry.name);
        Walk walk(entry.name, {entry.name.starts_with("city-") ? "scale=0.02" : "scale=0.05"});
        expectSamePixels(walk, warped ? "lispsm" : "cascaded", {{"filter", "pcf2"}}, methods);
        warped = !warped;
    }
}

TEST(Camera, NoMethodChangesTheDepthImage) {
    for (const TestScene& scene : kThree) {
        Walk walk(scene.name, scene.settings);
        const std::vector<Walk::Image> truth = walk.images("unshadowed", {{"camera", "none"}});
        for (const char* method : {"frustum", "chc", "chcpp", "hiz"})
            for (const char* cluster : {"0", "200"}) {
                const std::vector<Walk::Image> images = walk.images("unshadowed", {{"camera", method}, {"cluster", cluster}});
                for (size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(images[i].depth, truth[i].depth) << scene.name << " " << method << " " << cluster << " view " << i;
            }
    }
}

// Against a loop over all instances: the same list, in the same order, to the bit.
TEST(Lists, AreThoseOfALinearLoop) {
    for (const TestScene& scene : kThree) {
        Walk walk(scene.name, scene.settings);
        for (const bool castersOnly : {false, true})
            for (const scenegen::View& at : walk.views) {
                walk.frame.look(at);
                const frame::Camera& camera = walk.frame.camera();
                visibility::ViewFrame view{.view = visibility::CullView::camera(camera.eye, camera.clipFromRelative, camera.near), .depth = &walk.frame.depth()};
                if (castersOnly) {
                    const shadow::LightBasis basis = shadow::lightBasis(walk.frame.light(), camera.forward);
                    view.view.planes.clear();
                    shadow::CasterCull(basis, camera, shadow::viewBody(camera, camera.near, camera.far, walk.frame.relativeSceneBox()), 0.5).appendPlanes(view.view.planes);
                }
                gpuscene::DrawList expected;
                walk.gpu.collect(camera.eye, [&](uint32_t i) {
                    return (!castersOnly || walk.gpu.items().part(i).castsShadow) && view.view.mayContain(walk.frame.relativeBox(i));
                }, expected);
                EXPECT_GT(expected.items.size(), 0u);
                visibility::ListCulling culling(walk.gpu.items(), castersOnly);
                culling.draw(view, [&](const gpuscene::DrawList& list) {
                    EXPECT_EQ(list.items, expected.items);
                    ASSERT_EQ(list.data.size(), expected.data.size());
                    EXPECT_EQ(std::memcmp(list.data.data(), expected.data.data(), list.data.size() * sizeof(gpuscene::InstanceData)), 0);
                });
                EXPECT_EQ(culling.drawn(), expected.items);
            }
    }
}

TEST(Queries, AreCountedByPass) {
    Walk walk("city-vienna", {"scale=0.03"});
    const shadow::TechniqueInfo& info = shadow::technique("cascaded");
    shadow::Renderer renderer(walk.frame, info, shadow::resolve(info, {{"camera", "chcpp"}, {"cull", "receivers"}, {"cascades", "2"}, {"size", "256"}}));
    frame::PassObserver silent;
    renderer.render(silent);
    std::vector<std::string> passes;
    for (const auto& [pass, statistics] : renderer.queryStatistics()) {
        passes.push_back(pass);
        EXPECT_GT(statistics.queries, 0u) << pass;
        EXPECT_GE(statistics.boxes, statistics.queries) << pass;
        EXPECT_GE(statistics.nodesVisited, statistics.nodesVisible) << pass;
    }
    EXPECT_EQ(passes, (std::vector<std::string>{"gbuffer", "map0", "map1"}));
    EXPECT_TRUE(shadow::Renderer(walk.frame, info, shadow::resolve(info, {{"camera", "hiz"}, {"cull", "pyramid"}})).queryStatistics().empty());
}

// A wire between the texel centres of a coarse map, in the shadow of a plate out of sight: what rasterises the receivers loses
// it, and with it the plate. The masks that are exact do not.
TEST(Masks, RasterisedOnesLoseReceiversBetweenTexelCentres) {
    scenegen::Scene scene;
    scene.name = "wire";
    scene.materials.resize(1);
    scene.prototypes.push_back({"wire", {scenegen::boxMesh({0.06f, 0.06f, 3})}, true, true});
    scene.prototypes.push_back({"plate", {scenegen::boxMesh({12, 12, 0.2f})}, true, true});
    scene.instances.push_back({{0, 8, 0}, 1, 0, 0});  // on the line between the two columns of texels in the middle
    scene.instances.push_back({{0, -22, 30}, 1, 0, 1});
    scene.sun = {180, 45};
    scene.views.push_back({"wire", {0, 0, 1.5}, {0, 1, 0}, {0, 0, 1}, 20, 0.1, 50});
    Walk walk(scene);
    const std::vector<Walk::Image> truth = walk.images("uniform", {{"size", "48"}, {"cull", "none"}});
    EXPECT_GT(std::ranges::count(truth[0].visibility, 0.0f), 50) << "the plate's shadow is on the wire";
    for (const auto& [mask, exact] : {std::pair("scatter", true), {"box", true}, {"geometry", false}, {"fragment", false}, {"fragment-or", false}}) {
        const size_t wrong = differences(walk.images("uniform", {{"size", "48"}, {"cull", "receivers"}, {"mask", mask}}), truth);
        EXPECT_EQ(wrong == 0, exact) << mask << ": " << wrong;
    }
}

// Cars drive on: hierarchies and the GPU's table of instances follow.
TEST(Moving, CullingFollowsTheInstances) {
    Walk walk("city-vienna", {"scale=0.03"});
    ASSERT_FALSE(walk.scene.motions.empty());
    for (const char* camera : {"chcpp", "frustum"}) walk.images("uniform", {{"camera", camera}, {"cull", "pyramid"}});  // what is made on first use is there
    walk.scene.moveTo(7);
    walk.gpu.instancesMoved();
    walk.frame.instancesMoved();
    expectSamePixels(walk, "uniform", {});
    Walk fresh("city-vienna", {"scale=0.03", "time=7"});
    EXPECT_EQ(walk.images("uniform", {{"cull", "pyramid"}}), fresh.images("uniform", {{"cull", "none"}}));
}

}  // namespace
}  // namespace dapple::bench
