// What culling leaves out must not change a pixel: every method, for every fit, split, filter and bias, along paths that jump.
#include "bench/gl_workbench.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::bench {
namespace {

GlWorkbench& workbench() {
    static GlWorkbench bench(-1, "cpu_finish");
    return bench;
}

constexpr int kWidth = 160, kHeight = 120;

/// A scene at test size, walked through with jumps: each view, twice the first, so that coherence has something to hold on to.
struct Walk {
    explicit Walk(const std::string& name, const std::vector<std::string>& settings)
        : scene(scenegen::loadScene(name, settings)), gpu((workbench(), scene)), frame(gpu, scene.views.front(), kWidth, kHeight) {
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
                                           {{"cull", "pyramid"}}};

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
    const std::vector<shadow::Settings> methods{{{"cull", "chcpp"}}, {{"cull", "receivers"}, {"camera", "chcpp"}}, {{"cull", "pyramid"}}};
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
        for (const char* method : {"frustum", "chc", "chcpp"}) {
            const std::vector<Walk::Image> images = walk.images("unshadowed", {{"camera", method}});
            for (size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(images[i].depth, truth[i].depth) << scene.name << " " << method << " view " << i;
        }
    }
}

}  // namespace
}  // namespace dapple::bench
