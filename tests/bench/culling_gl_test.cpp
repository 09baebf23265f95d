// What culling leaves out must not change a pixel: every method, for every fit, split, filter and bias, along paths that jump.
#include "bench/gl_workbench.h"
#include "scenegen/library.h"
#include "scenegen/primitives.h"
#include "shadow/map/caster_cull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

namespace dapple::bench {
namespace {

GlWorkbench& workbench() {
    static GlWorkbench bench(-1, "cpu_finish");
    return bench;
}

constexpr int kWidth = 160, kHeight = 120;

/// A scene at test size, walked through with jumps: each view, twice the first, so that coherence has something to hold on to.
struct Walk {
    Walk(const std::string& name, const std::vector<std::string>& settings) : Walk(scenegen::loadScene(name, settings)) {}
    explicit Walk(scenegen::Scene made)
        : scene(std::move(made)), gpu((workbench(), scene)), frame(gpu, scene.views.front(), kWidth, kHeight) {
        for (size_t i = 0; i < std::min<size_t>(scene.views.size(), 3); ++i) views.push_back(scene.views[i]);
        views.insert(views.begin(), views.front());
    }

    struct Image {
        std::vector<float> visibility, depth;
        bool operator==(const Image&) const = default;
    };
    /// One renderer, image after image; its first frame sees a cut like all others.
    std::vector<Image> images(const std::string& technique, shadow::Settings axes) {
        if (technique != "unshadowed") axes.try_emplace("size", "256");
        const shadow::TechniqueInfo& info = shadow::technique(technique);
        const shadow::Settings settings = shadow::resolve(info, axes);
        EXPECT_FALSE(shadow::pruneReason(info, settings, gpu.facts(), workbench().limits()));
        frame.look(views.front());
        shadow::Renderer renderer(frame, info, settings);
        std::vector<Image> result;
        frame::PassObserver silent;
        for (const scenegen::View& view : views) {
            frame.look(view);
            renderer.replan();
            renderer.render(silent);
            result.push_back({renderer.visibility(), frame.readChannel(frame.depth()).texels});
        }
        gl::checkErrors("a walk");
        return result;
    }

    scenegen::Scene scene;
    gpuscene::GpuScene gpu;
    frame::Frame frame;
    std::vector<scenegen::View> views;
};

std::string text(const shadow::Settings& axes) {
    std::string text;
    for (const auto& [axis, value] : axes) text += " " + axis + "=" + value;
    return text;
}

size_t differences(const std::vector<Walk::Image>& a, const std::vector<Walk::Image>& b) {
    size_t count = 0;
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t p = 0; p < a[i].visibility.size(); ++p) count += a[i].visibility[p] != b[i].visibility[p];
    return count;
}

/// Methods that must give what cull none gives.
const std::vector<shadow::Settings> kExact{{{"cull", "frustum"}},
                                           {{"cull", "chc"}},
                                           {{"cull", "chcpp"}, {"leaf", "2000"}, {"batch", "4"}},
                                           {{"cull", "receivers"}},
                                           {{"cull", "receivers"}, {"camera", "chcpp"}, {"mask-test", "stencil"}},
                                           {{"cull", "receivers"}, {"camera", "chc"}, {"mask", "box"}},
                                           {{"cull", "hiz"}},
                                           {{"cull", "pyramid"}, {"camera", "hiz"}},
                                           {{"cull", "frustum"}, {"cluster", "300"}},
                                           {{"cull", "receivers"}, {"camera", "chcpp"}, {"cluster", "300"}, {"leaf", "500"}},
                                           {{"cull", "hiz"}, {"cluster", "300"}},
                                           {{"cull", "pyramid"}, {"camera", "hiz"}, {"cluster", "60"}}};

void expectSamePixels(Walk& walk, const std::string& technique, const shadow::Settings& sampling, const std::vector<shadow::Settings>& methods = kExact) {
    shadow::Settings all = sampling;
    all["cull"] = "none";
    const std::vector<Walk::Image> truth = walk.images(technique, all);
    for (shadow::Settings axes : methods) {
        SCOPED_TRACE(technique + text(sampling) + text(axes));
        for (const auto& [axis, value] : sampling) axes[axis] = value;
        EXPECT_EQ(differences(walk.images(technique, axes), truth), 0u);
    }
}

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
