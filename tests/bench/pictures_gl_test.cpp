// Pictures at the ends of what there is to show: passes that are left out, eyes within shadow volumes, triangles without area,
// light that a screen cannot hold.
#include "base/error.h"
#include "bench/fixture.h"
#include "bench/picture.h"
#include "bench/stage.h"
#include "scenegen/library.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::bench {
namespace {

/// Empty where a file was written, else the one line that says why not.
std::string reasonFor(const PointSpec& point, const std::string& what, const std::filesystem::path& file) {
    std::filesystem::remove(file);
    try {
        renderPicture(workbench(), point, what, file);
    } catch (const base::UsageError& e) {
        return e.what();
    }
    EXPECT_TRUE(std::filesystem::exists(file)) << what;
    return {};
}

TEST(Pictures, AreDrawnOrSayWhyNotWhateverPassIsLeftOut) {
    const TemporaryFolder folder;
    const std::vector<std::pair<std::string, std::string>> scenes{{"empty", ""}, {"box", "no-caster"}, {"box", "sun-below"}, {"box", ""}};
    const std::vector<std::pair<std::string, shadow::Settings>> more{
        {"uniform", {{"cull", "pyramid"}}}, {"cascaded", {{"cull", "pyramid"}}}, {"cascaded", {{"cull", "receivers"}}}, {"lispsm", {{"cull", "hiz"}}},
        {"focused", {{"cull", "chcpp"}}}, {"instanced", {{"far-field", "auto"}}}, {"instanced", {{"exact-casters", "100"}}}, {"instanced", {{"apply", "tiled"}}}};
    std::vector<std::pair<std::string, shadow::Settings>> techniques = more;
    for (const shadow::TechniqueInfo& info : shadow::techniques()) techniques.push_back({info.name, {}});
    size_t drawn = 0, refused = 0;
    for (const auto& [scene, stress] : scenes)
        for (const auto& [technique, axes] : techniques)
            for (const PictureKind& kind : pictureKinds()) {
                SCOPED_TRACE(scene + " " + stress + " " + technique + " " + kind.name);
                const shadow::TechniqueInfo& info = shadow::technique(technique);
                shadow::Settings small = axes;
                if (info.defaults.contains("size")) small["size"] = "64";
                PointSpec point{scene, {}, stress, technique, shadow::resolve(info, small), scenegen::loadScene(scene).views.front().name, 64, 48, {}};
                if (stress == "sun-below") point.stressCase.clear(), point.sceneSettings = {"sun.elevation=-5"};
                const std::string reason = reasonFor(point, kind.name, folder.path / "picture.png");
                EXPECT_EQ(reason.find('\n'), std::string::npos) << reason;
                ++(reason.empty() ? drawn : refused);
            }
    EXPECT_GT(drawn, refused);
    EXPECT_GT(refused, 0u);
}

/// Boxes of casters, shrunk by a millimetre, that the ray from `p` toward the sun meets.
int boxesTowardsSun(const Stage& stage, const glm::dvec3& p) {
    int count = 0;
    for (const scenegen::Instance& instance : stage.scene.instances) {
        const scenegen::Prototype& prototype = stage.scene.prototypes[instance.prototype];
        if (!prototype.castsShadow) continue;
        const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw));
        const auto turnBack = [&](const glm::dvec3& v) { return glm::dvec3(c * v.x + s * v.y, c * v.y - s * v.x, v.z); };
        const glm::dvec3 q = turnBack(p - glm::dvec3(instance.translation)), ray = -turnBack(stage.frame.light());
        const base::Box box = prototype.box();
        double enter = 0, leave = 1e300;
        for (int k = 0; k < 3; ++k) {
            const double a = (double(box.lo[k]) * double(instance.scale) + 1e-3 - q[k]) / ray[k];
            const double b = (double(box.hi[k]) * double(instance.scale) - 1e-3 - q[k]) / ray[k];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        count += enter <= leave;
    }
    return count;
}

TEST(InstancedVolumes, HaveNoFragmentsWhereNoLightArrivesThoughTheyHoldTheEye) {
    Stage stage(scenegen::loadScene("forest-small", {"sun.elevation=40"}), 96, 72);
    // Behind a tree, seen from the sun, with the horizon in sight.
    const auto tree = std::ranges::find_if(stage.scene.instances, [&](const scenegen::Instance& i) { return stage.scene.prototypes[i.prototype].castsShadow; });
    scenegen::View view = stage.scene.views.front();
    view.eye = glm::dvec3(tree->translation) + glm::dvec3(0, 0, 4) + stage.frame.light() * 1.0;
    view.forward = glm::normalize(glm::dvec3(-stage.frame.light().x, -stage.frame.light().y, 0.05));
    view.up = {0, 0, 1};
    stage.frame.look(view);
    ASSERT_GE(boxesTowardsSun(stage, view.eye), 1);
    std::vector<float> seen;
    for (const char* cull : {"receivers", "mask"})
        for (const char* apply : {"zpass", "zfail"}) {
            SCOPED_TRACE(std::string(cull) + " " + apply);
            const shadow::TechniqueInfo& info = shadow::technique("instanced");
            shadow::Renderer renderer(stage.frame, info, shadow::resolve(info, {{"size", "128"}, {"cull", cull}, {"apply", apply}}));
            const base::ImageF fragments = renderer.volumeOverdraw().value();
            const std::vector<float> visibility = renderer.visibility();
            const std::vector<uint8_t> asks = stage.frame.readValidity();
            const truth::Receivers receivers = stage.frame.readReceivers();
            size_t unasked = 0, tooFew = 0, unlit = 0;
            for (size_t i = 0; i < asks.size(); ++i) {
                if (!asks[i]) ++unlit, unasked += fragments.texels[i] > 0;
                else tooFew += fragments.texels[i] < float(boxesTowardsSun(stage, glm::dvec3(receivers.position[i]) + view.eye));
            }
            EXPECT_GT(unlit, asks.size() / 20);
            EXPECT_EQ(unasked, 0u);
            EXPECT_EQ(tooFew, 0u);
            if (seen.empty()) seen = visibility;
            EXPECT_EQ(seen, visibility);
        }
}

TEST(Slivers, AreNotDrawn) {
    std::vector<std::vector<float>> depths;
    for (const bool with : {true, false}) {
        scenegen::Scene scene = scenegen::loadScene("extreme-slivers");
        const auto isSlivers = [&](const scenegen::Instance& i) { return scene.prototypes[i.prototype].name == "slivers"; };
        ASSERT_EQ(std::ranges::count_if(scene.instances, isSlivers), 1);
        if (!with) std::erase_if(scene.instances, isSlivers);
        Stage stage(std::move(scene), 640, 480);
        stage.frame.look(stage.scene.views.front());
        shadow::Renderer renderer(stage.frame, shadow::technique("uniform"), shadow::technique("uniform").defaults);
        frame::PassObserver silent;
        renderer.render(silent);
        depths.push_back(stage.frame.readChannel(stage.frame.depth()).texels);
    }
    size_t different = 0;
    for (size_t i = 0; i < depths[0].size(); ++i) different += depths[0][i] != depths[1][i];
    EXPECT_EQ(different, 0u);
}

TEST(Exposure, LeavesNoLitDiffuseSurfaceWhiteOnWhite) {
    scenegen::Scene scene;
    scene.name = "plate";
    scene.materials.resize(2);
    scene.materials[0].albedo = glm::vec3(0.5f);
    scene.materials[1].albedo = glm::vec3(0.9f);
    scene.prototypes = {{"ground", {scenegen::boxMesh({400, 400, 1})}, true, true}, {"tile", {scenegen::boxMesh({2, 2, 0.1f})}, true, true}};
    scene.prototypes[1].meshes[0].material = 1;
    scene.instances = {{{0, 0, -1}, 1, 0, 0}, {{0, 0, 0.1f}, 1, 0, 1}};
    scene.views.push_back({"above", {0, -3, 6}, glm::normalize(glm::dvec3(0, 3, -6)), {0, 0, 1}, 50, 0.5, 100});
    Stage stage(std::move(scene), 80, 60);
    shadow::Renderer renderer(stage.frame, shadow::technique("unshadowed"), shadow::technique("unshadowed").defaults);
    for (const double elevation : {90.0, 80.0, 45.0, 10.0}) {
        stage.frame.setSun({200, elevation});
        renderer.replan();
        frame::PassObserver silent;
        renderer.render(silent);
        const base::Image8 picture = stage.frame.readShaded();
        const uint8_t *tile = picture.at(40, 30), *ground = picture.at(2, 57);
        for (int k = 0; k < 3; ++k) {
            EXPECT_LT(tile[k], 255) << elevation;
            EXPECT_GT(tile[k], ground[k] + 10) << elevation;
        }
    }
}

}  // namespace
}  // namespace dapple::bench
