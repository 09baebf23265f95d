// Several suns in one frame: each has the image that it would have alone.
#include "base/error.h"
#include "bench/stage.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace dapple::bench {
namespace {

struct Images {
    std::vector<std::vector<float>> visibility;  // by sun
    std::string fallback;
    base::Image8 shaded;
};

Images render(Stage& stage, const shadow::TechniqueInfo& info, const shadow::Settings& axes) {
    shadow::Renderer renderer(stage.frame, info, shadow::resolve(info, axes));
    frame::PassObserver silent;
    for (int i = 0; i < 2; ++i) renderer.render(silent);  // cached maps are not passes of the first frame alone
    Images images{{}, renderer.fallback(), stage.frame.readShaded()};
    for (size_t sun = 0; sun < stage.frame.suns(); ++sun) images.visibility.push_back(renderer.visibility(sun));
    gl::checkErrors("suns");
    return images;
}

scenegen::Scene underOneSun(scenegen::Scene scene, const scenegen::Sun& sun) {
    scene.sun = sun;
    scene.furtherSuns.clear();
    return scene;
}

TEST(Suns, EachTechniqueDrawsForEachWhatItDrawsForOne) {
    for (const char* name : {"forest-two-suns", "flythrough"}) {
        scenegen::Scene scene = scenegen::loadScene(name, {});
        if (scene.furtherSuns.empty()) scene.furtherSuns = {{scene.sun.azimuth + 70, 35, 0.5}, {scene.sun.azimuth - 100, 60, 0.25}};
        Stage several(scene);
        std::vector<std::unique_ptr<Stage>> alone{};
        alone.push_back(std::make_unique<Stage>(underOneSun(scene, scene.sun)));
        for (const scenegen::Sun& sun : scene.furtherSuns) alone.push_back(std::make_unique<Stage>(underOneSun(scene, sun)));
        ASSERT_EQ(several.frame.suns(), alone.size());
        size_t tried = 0;
        for (const shadow::TechniqueInfo& info : shadow::techniques()) {
            if (info.family == "baseline") continue;
            shadow::Settings axes;
            if (info.defaults.contains("size")) axes["size"] = "256";
            if (shadow::pruneReason(info, shadow::resolve(info, axes), several.gpu.facts(), workbench().limits())) continue;
            SCOPED_TRACE(std::string(name) + " " + info.name);
            const Images images = render(several, info, axes);
            for (size_t sun = 0; sun < alone.size(); ++sun) EXPECT_EQ(images.visibility[sun], render(*alone[sun], info, axes).visibility[0]) << "sun " << sun + 1;
            EXPECT_NE(images.visibility[0], images.visibility[1]);
            ++tried;
        }
        EXPECT_GE(tried, 6u);
    }
}

TEST(Suns, ErrorsAreOfEachSunAndTheirMean) {
    PointSpec spec;
    spec.scene = "forest-two-suns", spec.technique = "focused", spec.view = "above", spec.width = 120, spec.height = 90;
    spec.settings = shadow::resolve(shadow::technique("focused"), {{"size", "256"}});
    std::map<std::string, double> errors;
    for (const Figure& f : workbench().open(spec)->errors())
        if (f.metric == "error") errors[f.pass] = f.value.value();
    ASSERT_EQ(errors.size(), 3u);
    EXPECT_NE(errors["sun 1"], errors["sun 2"]);
    EXPECT_DOUBLE_EQ(errors[""], (errors["sun 1"] + errors["sun 2"]) / 2);
    spec.sceneSettings = {"sun.azimuth=265", "sun.elevation=25"};  // where the second stands: the same image, the same truth
    for (const Figure& f : workbench().open(spec)->errors()) {
        if (f.metric == "error" && f.pass == "sun 1") { EXPECT_DOUBLE_EQ(f.value.value(), errors["sun 2"]); }
    }
}

TEST(Suns, ThatHaveSetReachNothingAndSaySo) {
    scenegen::Scene scene = scenegen::loadScene("forest-two-suns", {});
    scene.furtherSuns[0].elevation = -3;
    Stage stage(scene);
    const Images images = render(stage, shadow::technique("focused"), {{"size", "256"}});
    EXPECT_TRUE(std::ranges::all_of(images.visibility[1], [](float v) { return v == 0; }));
    EXPECT_TRUE(std::ranges::any_of(images.visibility[0], [](float v) { return v == 1; }));
    EXPECT_NE(images.fallback.find("sun 2: focused → night"), std::string::npos) << images.fallback;
}

/// Light behind a value of the picture, which is sRGB and exposed so that a white wall square to suns of this strength is just
/// white: c / (1 + k c), k = 1 − 1 / white.
double lightOf(double texel, double suns) {
    const double v = texel / 255, y = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    const double white = 0.36 + 2.6 * suns;  // red, the brightest channel: sky and suns
    return y / (1 - std::max(0.25, 1 - 1 / white) * y);
}

TEST(Suns, AddUpInThePicture) {
    const scenegen::Scene scene = scenegen::loadScene("forest-two-suns", {});
    Stage both(scene), first(underOneSun(scene, scene.sun));
    const Images two = render(both, shadow::technique("focused"), {}), one = render(first, shadow::technique("focused"), {});
    const double suns = 1 + scene.furtherSuns.at(0).strength;
    size_t brighter = 0, darker = 0;
    for (size_t i = 0; i < two.shaded.texels.size(); ++i) {
        const int t = two.shaded.texels[i], o = one.shaded.texels[i];
        if (t == o) continue;  // the sky
        // Each texel stands for all that rounds to it.
        brighter += lightOf(t - 0.5, suns) > lightOf(o + 0.5, 1);
        darker += lightOf(t + 0.5, suns) < lightOf(o - 0.5, 1);
    }
    EXPECT_EQ(darker, 0u);
    EXPECT_GT(brighter, two.shaded.texels.size() / 3);
}

TEST(Suns, AreRefusedBeyondFour) {
    scenegen::Scene scene = scenegen::loadScene("box", {});
    scene.furtherSuns.assign(3, {});
    EXPECT_NO_THROW(scenegen::validate(scene));
    scene.furtherSuns[2].strength = 0;
    EXPECT_THROW(scenegen::validate(scene), base::UsageError);
    scene.furtherSuns.assign(4, {});
    EXPECT_THROW(scenegen::validate(scene), base::UsageError);
}

}  // namespace
}  // namespace dapple::bench
