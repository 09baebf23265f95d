// Shadows of translucent casters against closed forms: where the shadows of two boxes overlap, their transmittances multiply.
#include "base/error.h"
#include "gl/context.h"
#include "scenegen/export/glb.h"
#include "scenegen/library.h"
#include "scenegen/primitives.h"
#include "shadow/renderer.h"
#include "truth/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>

namespace dapple::shadow {
namespace {

constexpr float kFirst = 0.75f, kSecond = 0.375f;
constexpr uint64_t kBoxHash = 0x9f8ecad853930bcb;

/// Two boxes one above the other and to the side, over a ground; the sun of a recipe's default.
scenegen::Scene twoBoxes(float first, float second) {
    scenegen::Scene scene;
    scene.name = "two boxes";
    scene.materials.resize(1);
    const auto add = [&](const glm::vec3& size, const glm::vec3& at, float transmittance, bool casts) {
        scenegen::Prototype prototype{"box", {scenegen::boxMesh(size)}, casts, true};
        prototype.transmittance = transmittance;
        scene.prototypes.push_back(std::move(prototype));
        scene.instances.push_back({.translation = at, .prototype = uint32_t(scene.prototypes.size() - 1)});
    };
    add({40, 40, 1}, {0, 0, -0.5f}, 0, false);
    add({3, 3, 0.5f}, {0, 0, 3}, first, true);
    add({3, 3, 0.5f}, {1.2f, -0.8f, 5}, second, true);
    scene.views.push_back({"above", {-8, 6, 14}, glm::normalize(glm::dvec3(-2, 2, 0) - glm::dvec3(-8, 6, 14)), {0, 0, 1}, 60, 0.5, 100});
    scene.sun = {150, 50};
    return scene;
}

/// Whether the ray from p toward the sun meets a box grown by `margin`.
bool meets(const scenegen::Scene& scene, size_t instance, const glm::dvec3& p, double margin) {
    const base::Box box = scene.prototypes[scene.instances[instance].prototype].box();
    const glm::dvec3 q = p - glm::dvec3(scene.instances[instance].translation), ray = -scene.sun.direction();
    double enter = 0, leave = 1e300;
    for (int k = 0; k < 3; ++k) {
        const double a = (double(box.lo[k]) - margin - q[k]) / ray[k], b = (double(box.hi[k]) + margin - q[k]) / ray[k];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

class Translucent : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);
    frame::PassObserver silent_;

    /// Calls check(closed form, pixel) for the ground's pixels that are no nearer than 10 cm to a shadow's edge; counts them
    /// by closed form.
    std::map<float, size_t> onGround(const scenegen::Scene& scene, const frame::Frame& frame, const std::function<void(float, size_t)>& check) {
        const truth::Receivers receivers = frame.readReceivers();
        std::map<float, size_t> counts;
        for (size_t i = 0; i < receivers.present.size(); ++i) {
            const glm::dvec3 p = glm::dvec3(receivers.position[i]) + frame.camera().eye;
            if (!receivers.present[i] || std::abs(p.z) > 1e-3) continue;
            float share = 1;
            bool edge = false;
            for (const size_t box : {1, 2}) {
                edge |= meets(scene, box, p, 0.1) != meets(scene, box, p, -0.1);
                if (meets(scene, box, p, 0)) share *= scene.prototypes[scene.instances[box].prototype].transmittance;
            }
            if (edge) continue;
            ++counts[share];
            check(share, i);
        }
        return counts;
    }
};

TEST_F(Translucent, TransmittancesMultiplyWhereShadowsOverlap) {
    const scenegen::Scene scene = twoBoxes(kFirst, kSecond);
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[0], 240, 180);
    for (const char* apply : {"zpass", "zfail", "skip"})
        for (const char* mode : {"nearest", "depth", "exact"}) {
            Renderer renderer(frame, technique("instanced"), resolve(technique("instanced"), {{"accumulate", "multiply"}, {"apply", apply}, {"mode", mode}}));
            renderer.render(silent_);
            EXPECT_EQ(renderer.fallback(), "");
            const std::vector<float> visibility = renderer.visibility();
            const auto counts = onGround(scene, frame, [&](float share, size_t i) { ASSERT_NEAR(visibility[i], share, 1e-3) << apply << mode << i; });
            EXPECT_EQ(counts.size(), 4u);  // 1, t1, t2, t1 t2
            for (const auto& [share, n] : counts) EXPECT_GT(n, 80u) << share;
        }
    const truth::Reference reference = truth::Tracer(scene).trace(frame.readReceivers(), frame.camera().eye, frame.light());
    onGround(scene, frame, [&](float share, size_t i) {
        ASSERT_EQ(reference.transmitted[i], share) << i;
        ASSERT_EQ(reference.label[i], share < 0.5f ? truth::Label::shadowed : truth::Label::lit) << i;
    });
    // The technique against the truth, everywhere, the boxes' own faces too.
    Renderer renderer(frame, technique("instanced"), resolve(technique("instanced"), {{"accumulate", "multiply"}}));
    renderer.render(silent_);
    EXPECT_LT(truth::measureError(reference, renderer.visibility()).meanAbsolute, 0.005);
}

TEST_F(Translucent, MapsOfTheWholeSceneAreOpaqueAndSaySo) {
    const scenegen::Scene scene = twoBoxes(kFirst, kSecond);
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[0], 240, 180);
    for (const char* name : {"uniform", "cascaded", "stencil-volumes"}) {
        Renderer renderer(frame, technique(name), technique(name).defaults);
        renderer.render(silent_);
        EXPECT_NE(renderer.fallback().find("opaque casters"), std::string::npos) << name;
        const std::vector<float> visibility = renderer.visibility();
        onGround(scene, frame, [&](float share, size_t i) { ASSERT_EQ(visibility[i], share < 1 ? 0 : 1) << name << i; });
        const truth::Reference reference = truth::Tracer(scene).trace(frame.readReceivers(), frame.camera().eye, frame.light());
        EXPECT_GT(truth::measureError(reference, visibility).meanAbsolute, 0.01) << name;
    }
}

TEST_F(Translucent, OfOpaqueScenesNothingChanges) {
    const scenegen::Scene opaque = twoBoxes(0, 0), half = twoBoxes(0, kSecond);
    EXPECT_FALSE(opaque.facts().translucent);
    EXPECT_TRUE(half.facts().translucent);
    EXPECT_NE(opaque.contentHash(), half.contentHash());
    EXPECT_NE(twoBoxes(0, 0.25f).contentHash(), half.contentHash());
    // The hash that this scene had before casters could let light through.
    EXPECT_EQ(scenegen::loadScene("box").contentHash(), kBoxHash);
    const gpuscene::GpuScene gpu(opaque);
    frame::Frame frame(gpu, opaque.views[0], 160, 120);
    Renderer renderer(frame, technique("instanced"), technique("instanced").defaults);
    renderer.render(silent_);
    EXPECT_TRUE(truth::Tracer(opaque).trace(frame.readReceivers(), frame.camera().eye, frame.light()).transmitted.empty());
    const TechniqueInfo& info = technique("instanced");
    EXPECT_FALSE(pruneReason(info, info.defaults, opaque.facts(), {}));
    for (const char* accumulate : {"min", "stencil"})
        EXPECT_NE(pruneReason(info, resolve(info, {{"accumulate", accumulate}}), half.facts(), {}).value_or("").find("accumulate multiply"), std::string::npos);
    EXPECT_FALSE(pruneReason(info, resolve(info, {{"accumulate", "multiply"}}), half.facts(), {}));
}

// An opaque box below a translucent one: what is dark stays dark.
TEST_F(Translucent, OpaqueCastersAmongThemStayOpaque) {
    const scenegen::Scene scene = twoBoxes(kFirst, 0);
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[0], 240, 180);
    Renderer renderer(frame, technique("instanced"), resolve(technique("instanced"), {{"accumulate", "multiply"}}));
    renderer.render(silent_);
    const std::vector<float> visibility = renderer.visibility();
    const truth::Reference reference = truth::Tracer(scene).trace(frame.readReceivers(), frame.camera().eye, frame.light());
    const auto counts = onGround(scene, frame, [&](float share, size_t i) {
        ASSERT_NEAR(visibility[i], share, 1e-3) << i;
        ASSERT_EQ(reference.transmitted[i], share) << i;
    });
    EXPECT_EQ(counts.size(), 3u);
}

/// Of the two boxes' scene, sheets of 3 × 3 m in the boxes' place, one turned, whose texture of 4 × 4 texels has holes.
scenegen::Scene twoSheets() {
    scenegen::Scene scene = twoBoxes(kFirst, kSecond);
    scenegen::Texture texture{"holes", base::Image8{4, 4, 4, std::vector<uint8_t>(64)}};
    for (int i = 0; i < 16; ++i)
        for (int channel = 0; channel < 4; ++channel) texture.image.texels[size_t(4 * i + channel)] = channel < 3 || (i * 7 + i / 4) % 3 != 0 ? 255 : 0;
    scene.textures.push_back(texture);
    scene.materials.push_back({.name = "holes", .texture = 0, .alphaTested = true});
    scenegen::Mesh sheet;
    sheet.positions = {{-1.5f, -1.5f, 0}, {1.5f, -1.5f, 0}, {1.5f, 1.5f, 0}, {-1.5f, 1.5f, 0}};
    sheet.normals.assign(4, {0, 0, 1});
    sheet.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    sheet.indices = {0, 1, 2, 0, 2, 3};
    sheet.material = 1;
    for (const size_t i : {1, 2}) scene.prototypes[i].meshes = {sheet}, scene.prototypes[i].closed = false;
    scene.instances[2].yaw = 0.5f;
    return scene;
}

// Where a texel is a hole a translucent caster lets all light through, where it is none its share, in maps as in the truth.
TEST_F(Translucent, HolesOfAlphaTestedCastersLetAllLightThrough) {
    const scenegen::Scene scene = twoSheets();
    EXPECT_TRUE(scene.facts().alphaTested && scene.facts().translucent);
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[0], 240, 180);
    Renderer renderer(frame, technique("instanced"), resolve(technique("instanced"), {{"accumulate", "multiply"}, {"mode", "exact"}, {"size", "1024"}}));
    renderer.render(silent_);
    const std::vector<float> visibility = renderer.visibility();
    const truth::Receivers receivers = frame.readReceivers();
    const truth::Reference reference = truth::Tracer(scene).trace(receivers, frame.camera().eye, frame.light());
    std::map<float, size_t> counts;
    size_t holes = 0;
    for (size_t pixel = 0; pixel < receivers.present.size(); ++pixel) {
        const glm::dvec3 p = glm::dvec3(receivers.position[pixel]) + frame.camera().eye;
        if (!receivers.present[pixel] || std::abs(p.z) > 1e-3) continue;
        float share = 1;
        bool edge = false, hole = false;
        for (const size_t i : {1, 2}) {
            const scenegen::Instance& sheet = scene.instances[i];
            const glm::dvec3 toSun = -scene.sun.direction(), at = p + toSun * ((double(sheet.translation.z) - p.z) / toSun.z) - glm::dvec3(sheet.translation);
            const double c = std::cos(double(sheet.yaw)), s = std::sin(double(sheet.yaw));
            const glm::dvec2 texel = (glm::dvec2(c * at.x + s * at.y, c * at.y - s * at.x) + 1.5) / 0.75;
            for (int k = 0; k < 2; ++k) edge |= std::abs(texel[k] - std::round(texel[k])) < 0.08;
            if (texel.x < 0 || texel.y < 0 || texel.x >= 4 || texel.y >= 4) continue;
            const bool opaque = scene.textures[0].image.texels[4 * size_t(int(texel.y) * 4 + int(texel.x)) + 3] != 0;
            hole |= !opaque;
            if (opaque) share *= scene.prototypes[sheet.prototype].transmittance;
        }
        if (edge) continue;
        ++counts[share];
        holes += hole;
        ASSERT_EQ(reference.transmitted[pixel], share) << pixel;
        ASSERT_NEAR(visibility[pixel], share, 1e-3) << pixel;
    }
    EXPECT_EQ(counts.size(), 4u);  // 1, t1, t2, t1 t2
    for (const auto& [share, n] : counts) EXPECT_GT(n, 80u) << share;
    EXPECT_GT(holes, 200u);
}

TEST(TranslucentScenes, RecipesFilesAndValidationKnowTransmittance) {
    const scenegen::Scene scene = scenegen::loadScene("box", {"primitive.0.transmittance=0.25"});
    EXPECT_TRUE(scene.facts().translucent);
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "translucent.glb";
    scenegen::writeGlb(scene, file);
    EXPECT_EQ(scenegen::loadScene(file.string()).contentHash(), scene.contentHash());
    EXPECT_THROW(scenegen::loadScene("box", {"primitive.0.transmittance=1"}), base::UsageError);
    EXPECT_THROW(scenegen::loadScene("box", {"primitive.0.transmittance=-0.1"}), base::UsageError);
    EXPECT_EQ(scenegen::loadScene("box", {"primitive.0.transmittance=0"}).contentHash(), scenegen::loadScene("box").contentHash());
    scenegen::Scene broken = twoBoxes(1, 0);
    EXPECT_THROW(scenegen::validate(broken), base::UsageError);
    broken = twoBoxes(std::nanf(""), 0);
    EXPECT_THROW(scenegen::validate(broken), base::UsageError);
}

}  // namespace
}  // namespace dapple::shadow
