// Scenes at the ends of what scenes can be: every technique of the registry draws finite images of every view.
#include "bench/stage.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::bench {
namespace {

std::vector<std::string> extremes() {
    std::vector<std::string> names{"nothing", "empty"};
    for (const scenegen::SceneEntry& entry : scenegen::listScenes())
        if (entry.name.starts_with("extreme-")) names.push_back(entry.name);
    return names;
}

class Extremes : public testing::TestWithParam<std::string> {};

TEST_P(Extremes, EveryTechniqueDrawsFiniteImages) {
    Stage stage(scenegen::loadScene(GetParam()), 96, 72);
    if (stage.scene.instances.size() > 10'000) stage.scene.views.resize(1);  // the software rasteriser takes seconds for each
    size_t drawn = 0;
    for (const shadow::TechniqueInfo& info : shadow::techniques()) {
        SCOPED_TRACE(info.name);
        shadow::Settings axes;
        if (info.defaults.contains("size")) axes["size"] = "256";
        const shadow::Settings settings = shadow::resolve(info, axes);
        const auto refused = shadow::pruneReason(info, settings, stage.gpu.facts(), workbench().limits());
        // Volumes of triangles without area are no bodies; all other casters here are closed.
        EXPECT_TRUE(!refused || (info.family == "volume" && GetParam() == "extreme-slivers")) << *refused;
        if (refused) continue;
        stage.frame.look(stage.scene.views.front());
        shadow::Renderer renderer(stage.frame, info, settings);
        for (const scenegen::View& view : stage.scene.views) {
            SCOPED_TRACE(view.name);
            stage.frame.look(view);
            renderer.replan();
            frame::PassObserver silent;
            renderer.render(silent);
            const auto finite = [](float v) { return std::isfinite(v) && v >= 0 && v <= 1; };
            if (renderer.hasVisibility()) {
                EXPECT_TRUE(std::ranges::all_of(renderer.visibility(), finite));
            }
            const std::vector<float> depth = stage.frame.readChannel(stage.frame.depth()).texels;
            EXPECT_TRUE(std::ranges::all_of(depth, finite));
            EXPECT_EQ(std::ranges::count(depth, depth.front()) == std::ptrdiff_t(depth.size()), GetParam() == "nothing") << "something is to be seen";
            gl::checkErrors("an extreme scene");
            ++drawn;
        }
        if (!renderer.technique()) continue;
        for (const shadow::LightMatrix& m : renderer.technique()->matrices()) EXPECT_TRUE(base::allFinite(m.clipFromRelative)) << m.name;
    }
    EXPECT_GE(drawn, stage.scene.views.size() * 5);
}
INSTANTIATE_TEST_SUITE_P(Registry, Extremes, testing::ValuesIn(extremes()), [](const auto& test) {
    std::string name = test.param;
    std::ranges::replace(name, '-', '_');
    return name;
});

}  // namespace
}  // namespace dapple::bench
