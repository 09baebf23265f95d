// Maps fitted to what is in sight hold every receiver that is, whatever comes into sight from frame to frame.
#include "bench/stage.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::bench {
namespace {

shadow::Settings settingsOf(const std::string& technique, shadow::Settings axes) {
    axes["focus"] = "visible";
    axes.try_emplace("size", "256");
    return shadow::resolve(shadow::technique(technique), axes);
}

TEST(Focus, EveryReceiverInSightIsInAMap) {
    Stage s(scenegen::loadScene("city-vienna", {"scale=0.03"}));
    for (const char* technique : {"focused", "lispsm", "cascaded"})
        for (const char* camera : {"frustum", "chc", "chcpp"}) {
            SCOPED_TRACE(std::string(technique) + " " + camera);
            shadow::Renderer renderer(s.frame, shadow::technique(technique), settingsOf(technique, {{"camera", camera}}));
            frame::PassObserver silent;
            for (const size_t view : {0, 0, 1, 2, 0}) {
                s.frame.look(s.scene.views[view]);
                renderer.replan();
                renderer.render(silent);
                const truth::Receivers seen = s.frame.readReceivers();
                const std::vector<shadow::LightMatrix> matrices = renderer.technique()->matrices();
                size_t outside = 0;
                for (size_t i = 0; i < seen.present.size(); ++i)
                    outside += seen.present[i] && std::none_of(matrices.begin(), matrices.end(), [&](const shadow::LightMatrix& m) {
                        const glm::dvec4 q = m.clipFromRelative * glm::dvec4(seen.position[i], 1);
                        return q.w > 0 && std::abs(q.x) <= q.w && std::abs(q.y) <= q.w && q.z >= 0 && q.z <= q.w;
                    });
                EXPECT_EQ(outside, 0u) << "view " << view;
            }
        }
}

TEST(Focus, CullingChangesNoPixel) {
    Stage s(scenegen::loadScene("city-vienna", {"scale=0.03"}));
    for (const char* technique : {"focused", "cascaded"}) {
        std::vector<float> all;
        for (const char* cull : {"none", "frustum", "chcpp", "receivers", "hiz", "pyramid"}) {
            shadow::Renderer renderer(s.frame, shadow::technique(technique), settingsOf(technique, {{"cull", cull}, {"filter", "pcf2"}}));
            frame::PassObserver silent;
            for (int i = 0; i < 2; ++i) renderer.render(silent);
            if (all.empty()) all = renderer.visibility();
            EXPECT_EQ(renderer.visibility(), all) << technique << " " << cull;
        }
    }
}

// In a street most of the frustum lies behind houses: the map that leaves it out errs less.
TEST(Focus, IsFinerWhereMuchIsHidden) {
    PointSpec spec;
    spec.scene = "city-vienna", spec.sceneSettings = {"scale=0.25"}, spec.technique = "focused", spec.view = "walk1";
    spec.width = 160, spec.height = 120;
    double error[2];
    for (const bool visible : {false, true}) {
        spec.settings = shadow::resolve(shadow::technique("focused"), {{"size", "1024"}, {"camera", "chcpp"}, {"focus", visible ? "visible" : "frustum"}});
        for (const Figure& f : workbench().open(spec)->errors())
            if (f.metric == "error") error[visible] = f.value.value();
    }
    EXPECT_LT(error[true], error[false]);
}

}  // namespace
}  // namespace dapple::bench
