// Techniques × bundled scenes: each pair renders, or says in a line why not. GL renders a sample in which every scene and every
// technique stands; what the others are refused for, and the instanced maps of all scenes, MapPlan's test plans without GL.
#include "bench/stage.h"
#include "scenegen/library.h"
#include "shadow/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace dapple::bench {
namespace {

/// What makes the large scenes small.
const std::map<std::string, std::vector<std::string>> kSmaller{
    {"city-vienna", {"scale=0.1"}}, {"city-vienna-night", {"scale=0.1"}}, {"city-manhattan", {"scale=0.04"}}};

TEST(EveryCell, RendersOrHasItsReason) {
    const auto techniques = shadow::techniques();
    std::set<std::string> rendered;
    size_t next = 0;
    for (const scenegen::SceneEntry& entry : scenegen::listScenes()) {
        const auto smaller = kSmaller.find(entry.name);
        Stage stage(scenegen::loadScene(entry.name, smaller == kSmaller.end() ? std::vector<std::string>{} : smaller->second), 64, 48);
        size_t here = 0;
        for (size_t tried = 0; tried < techniques.size() && here < 2; ++tried) {
            const shadow::TechniqueInfo& info = techniques[next++ % techniques.size()];
            SCOPED_TRACE(entry.name + " " + info.name);
            if (const auto reason = shadow::pruneReason(info, info.defaults, stage.gpu.facts(), workbench().limits())) {
                EXPECT_FALSE(reason->empty() || reason->find('\n') != std::string::npos) << *reason;
                continue;
            }
            ++here;
            rendered.insert(info.name);
            shadow::Renderer renderer(stage.frame, info, info.defaults);
            frame::PassObserver silent;
            renderer.render(silent);
            gl::checkErrors(info.name.c_str());
            if (!renderer.hasVisibility()) continue;
            EXPECT_TRUE(std::ranges::all_of(renderer.visibility(), [](float v) { return std::isfinite(v) && v >= 0 && v <= 1; }));
            for (const frame::Pass& pass : renderer.passes()) EXPECT_EQ(pass.leftOut.find('\n'), std::string::npos);
            EXPECT_EQ(renderer.fallback().find('\n'), std::string::npos);
        }
        EXPECT_GT(here, 0u) << entry.name;
    }
    EXPECT_EQ(rendered.size(), techniques.size());
}

// The flagship at its size, with both presets: within the memory that they may take, known before it is taken.
TEST(EveryCell, InstancedMapsOfAWholeCityKeepTheirMemory) {
    Stage stage(scenegen::loadScene("city-vienna"), 96, 72);
    for (const char* name : {"instanced", "instanced-near"}) {
        const shadow::TechniqueInfo& info = shadow::technique(name);
        shadow::Renderer renderer(stage.frame, info, info.defaults);
        frame::PassObserver silent;
        renderer.render(silent);
        gl::checkErrors(name);
        const size_t planned = renderer.technique()->plannedMapBytes().value();
        EXPECT_LE(planned, size_t(512) << 20);
        EXPECT_LE(renderer.mapBytes(), planned);
        EXPECT_NE(renderer.fallback().find("memory allows 512"), std::string::npos) << renderer.fallback();
        const std::vector<float> v = renderer.visibility();
        EXPECT_GT(std::ranges::count(v, 0.0f), std::ptrdiff_t(v.size() / 10));
    }
}

}  // namespace
}  // namespace dapple::bench
