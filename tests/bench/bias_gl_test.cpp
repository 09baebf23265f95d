// Planes in full light stay lit under the bias that is said to suffice for their slope and the filter's kernel: to the last bit
// where nothing else casts, and under every sun of the hemisphere but for shadows' edges.
#include "base/file.h"
#include "bench/stage.h"
#include "scenegen/library.h"
#include "scenegen/primitives.h"
#include "truth/metrics.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

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

/// A ground, a slab above it and walls that stand askew, apart from each other: planes of many directions, and no detail.
scenegen::Scene planes() {
    scenegen::Scene scene = plate(45);
    scene.name = "planes";
    scene.prototypes = {{"ground", {scenegen::boxMesh({40, 40, 1})}, true, true},
                        {"slab", {scenegen::boxMesh({6, 5, 0.3f})}, true, true},
                        {"wall", {scenegen::boxMesh({5, 0.6f, 4})}, true, true}};
    scene.instances = {{{0, 0, -1}, 1, 0, 0}, {{-6, 9, 2}, 1, 0, 1}};
    for (int i = 0; i < 4; ++i) scene.instances.push_back({{float(3 * i), float(2 + 3 * i), 0}, 1, float(glm::radians(30.0 * (1 + 2 * i))), 2});
    scene.views = {{"front", {2, -9, 7}, glm::normalize(glm::dvec3(0, 1, -0.45)), {0, 0, 1}, 60, 0.3, 100}};
    return scene;
}

std::string fixture(const std::string& name) { return (base::homeFolder() / "tests/fixtures" / name).string(); }

const char* const kTechniques[] = {"uniform", "focused", "lispsm", "cascaded", "instanced", "instanced-near"};

/// Pictures of 320×240 pixels of one scene's view, by one technique under one sun after the other, against the ray tracer.
class Judge {
public:
    Judge(scenegen::Scene scene, const char* view) : stage_(std::move(scene), 320, 240), tracer_(stage_.scene) {
        stage_.frame.look(stage_.scene.views[stage_.scene.viewIndex(view)]);
    }
    void use(const char* technique, const char* filter = "nearest") {
        shadow::Settings axes{{"filter", filter}};
        const shadow::TechniqueInfo& info = shadow::technique(technique);
        if (info.family == "instanced" && axes["filter"] != "nearest") axes["mode"] = "blend";
        renderer_.emplace(stage_.frame, info, shadow::resolve(info, axes));
    }
    truth::ErrorMetrics under(const scenegen::Sun& sun) {
        stage_.frame.setSun(sun);
        renderer_->replan();
        frame::PassObserver silent;
        renderer_->render(silent);
        const truth::Reference reference = tracer_.trace(stage_.frame.readReceivers(), stage_.frame.camera().eye, stage_.frame.light());
        return truth::measureError(reference, renderer_->visibility());
    }
    const scenegen::Sun& sun() const { return stage_.scene.sun; }

private:
    Stage stage_;
    truth::Tracer tracer_;
    std::optional<shadow::Renderer> renderer_;
};

class Hemisphere : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

// Azimuths by multiples of 30 degrees about that under which instanced maps are laid out: they have those rotations.
TEST_P(Hemisphere, HasNoSunUnderWhichPlanesShadowThemselves) {
    Judge judge(planes(), "front");
    const auto [technique, filter] = GetParam();
    judge.use(technique, filter);
    for (const double elevation : {0.001, 0.1, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 45.0, 70.0, 80.0, 88.0, 89.9, 89.999, 89.99999, 90.0})
        for (const double azimuth : {20.0, 110.0, 200.0, 320.0}) {
            const truth::ErrorMetrics m = judge.under({azimuth, elevation});
            // At and below one degree there are walls alone, some of few pixels: shadows' edges may cost a score of them.
            const double pixels = m.valid * 320 * 240, few = std::max(0.002, 20 / pixels);
            EXPECT_LE(m.falseShadow, few) << elevation << " from " << azimuth;
            if (filter == std::string("nearest")) {  // others blur the edges themselves
                EXPECT_LE(m.error, few) << elevation << " from " << azimuth;
            }
        }
}
INSTANTIATE_TEST_SUITE_P(Registry, Hemisphere, testing::Combine(testing::ValuesIn(kTechniques), testing::Values("nearest", "pcf2", "pcf3")));

TEST(Bias, KeepsASlabCleanUnderAHighSun) {
    Judge judge(scenegen::loadScene(fixture("slab-from-above.toml")), "above");
    for (const char* technique : kTechniques) {
        judge.use(technique);
        for (const double elevation : {89.9, 89.999, 89.99999, 90.0})
            EXPECT_LT(judge.under({judge.sun().azimuth, elevation}).error, 0.002) << technique << " " << elevation;
    }
}

TEST(Bias, LeavesNoAcneOnGrazedPlanes) {
    for (const char* scene : {"ground", "walls"}) {
        const bool ground = scene == std::string("ground");
        Judge judge(scenegen::loadScene(fixture(fmt::format("grazed-{}.gltf", scene))), ground ? "h105" : "h030");
        for (const char* technique : kTechniques)
            for (const char* filter : {"nearest", "pcf2", "pcf3"}) {
                judge.use(technique, filter);
                for (const double elevation : ground ? std::vector{1.5, 2.0, 3.0, 5.0} : std::vector{85.0, 88.0})
                    EXPECT_LT(judge.under({judge.sun().azimuth, elevation}).falseShadowInterior, 0.002) << scene << " " << technique << " " << filter << " " << elevation;
            }
    }
}

}  // namespace
}  // namespace dapple::bench
