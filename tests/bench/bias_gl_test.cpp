// A plane in full light stays lit, to the last bit, under the bias that is said to suffice for its slope and the filter's kernel.
#include "bench/stage.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::bench {
namespace {

scenegen::Scene plate(double elevation) {
    scenegen::Scene scene;
    scene.name = "plate";
    scene.materials.resize(1);
    scene.prototypes.push_back({"plate", {scenegen::boxMesh({400, 400, 1})}, true, true});
    scene.instances.push_back({{0, 0, -1}, 1, 0, 0});
    scene.sun = {200, elevation};
    scene.views.push_back({"near", {0, 0, 6}, glm::normalize(glm::dvec3(0.2, 1, -0.4)), {0, 0, 1}, 50, 0.5, 100});
    return scene;
}

TEST(SlopeBias, SufficesForEveryFilterOnAPlane) {
    for (const double elevation : {70, 40, 20}) {
        Stage stage(plate(elevation), 200, 150);
        for (const char* technique : {"uniform", "focused"})
            for (const char* filter : {"nearest", "pcf2", "pcf3"}) {
                shadow::Renderer renderer(stage.frame, shadow::technique(technique), shadow::resolve(shadow::technique(technique), {{"size", "128"}, {"filter", filter}}));
                frame::PassObserver silent;
                renderer.render(silent);
                const std::vector<float> v = renderer.visibility();
                const truth::Receivers seen = stage.frame.readReceivers();
                size_t receivers = 0, dark = 0;
                for (size_t i = 0; i < v.size(); ++i)
                    if (seen.present[i]) ++receivers, dark += v[i] != 1;
                EXPECT_GT(receivers, v.size() / 2);
                EXPECT_EQ(dark, 0u) << technique << " " << filter << " sun at " << elevation;
            }
    }
}

}  // namespace
}  // namespace dapple::bench
