// Candidate pixels of instanced shadow maps against a slab test in doubles, caster by caster.
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::shadow {
namespace {

/// Boxes of instances, given by prototype and grown by `margin` metres on each side, that the ray from `p` toward the sun meets. All in metres from the origin.
int boxesTowardsSun(const scenegen::Scene& scene, const std::vector<base::Box>& boxes, const glm::dvec3& p, const glm::dvec3& light, double margin) {
    int count = 0;
    for (const scenegen::Instance& instance : scene.instances) {
        if (!scene.prototypes[instance.prototype].castsShadow) continue;
        const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw)), scale = double(instance.scale);
        const auto turnBack = [&](const glm::dvec3& v) { return glm::dvec3(c * v.x + s * v.y, c * v.y - s * v.x, v.z); };
        const glm::dvec3 q = turnBack(p - glm::dvec3(instance.translation)), ray = -turnBack(light);
        const base::Box& box = boxes[instance.prototype];
        const glm::dvec3 lo = glm::dvec3(box.lo) * scale - margin, hi = glm::dvec3(box.hi) * scale + margin;
        double enter = 0, leave = 1e300;
        for (int k = 0; k < 3; ++k) {
            const double a = (lo[k] - q[k]) / ray[k], b = (hi[k] - q[k]) / ray[k];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        count += enter <= leave;
    }
    return count;
}

class Candidates : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);
    scenegen::Scene scene_ = scenegen::loadScene("forest-small", {"sun.elevation=60"});
    gpuscene::GpuScene gpu_{scene_};

    static Renderer make(frame::Frame& frame, Settings axes) {
        axes.try_emplace("size", "256");
        return {frame, technique("instanced"), resolve(technique("instanced"), axes)};
    }
};

TEST_F(Candidates, AreThePixelsThatFaceTheSunInAVolume) {
    std::vector<base::Box> boxes;
    for (const scenegen::Prototype& prototype : scene_.prototypes) boxes.push_back(prototype.box());
    size_t inside = 0, outside = 0, away = 0;
    for (const char* view : {"above", "walk1"}) {
        SCOPED_TRACE(view);
        frame::Frame frame(gpu_, scene_.views[scene_.viewIndex(view)], 120, 90);
        Renderer renderer = make(frame, {});
        const base::ImageF volumes = renderer.candidates().value();
        const truth::Receivers receivers = frame.readReceivers();
        const std::vector<float> visibility = renderer.visibility();
        const std::vector<uint8_t> validity = frame.readValidity();
        // A box is padded by some texels of its map; receivers are exact to float. 256 texels span at most 2 x 6 m.
        const double padding = 0.25;
        for (size_t i = 0; i < volumes.texels.size(); ++i) {
            const auto n = int(volumes.texels[i]);
            if (!receivers.present[i] || glm::dot(glm::dvec3(receivers.normal[i]), frame.light()) >= 0) {
                ASSERT_EQ(n, 0) << i << ": it asks no map";
                ++away;
                continue;
            }
            const glm::dvec3 p = glm::dvec3(receivers.position[i]) + frame.camera().eye;
            ASSERT_GE(n, boxesTowardsSun(scene_, boxes, p, frame.light(), -1e-3)) << i;
            ASSERT_LE(n, boxesTowardsSun(scene_, boxes, p, frame.light(), padding)) << i;
            // What no volume holds, no map can darken.
            ASSERT_TRUE(n > 0 || !validity[i] || visibility[i] == 1) << i;
            ++(n > 0 ? inside : outside);
        }
    }
    EXPECT_GT(inside, 3000u);
    EXPECT_GT(outside, 500u);
    EXPECT_GT(away, 1000u);
}

TEST_F(Candidates, DoNotDependOnHowTheMapsAreApplied) {
    frame::Frame frame(gpu_, scene_.views.front(), 120, 90);
    const std::vector<float> usual = make(frame, {}).candidates().value().texels;
    for (const Settings& way : {Settings{{"apply", "zpass"}}, Settings{{"apply", "skip"}}, Settings{{"accumulate", "stencil"}}, Settings{{"accumulate", "multiply"}},
                                Settings{{"cull", "mask"}}, Settings{{"mode", "nearest"}}}) {
        std::string name;
        for (const auto& [axis, value] : way) name += axis + "=" + value;
        const std::vector<float> other = make(frame, way).candidates().value().texels;
        size_t different = 0;
        for (size_t i = 0; i < usual.size(); ++i) different += usual[i] != other[i];
        EXPECT_EQ(different, 0u) << name;
    }
    for (const char* apply : {"tiled", "all"}) EXPECT_FALSE(make(frame, {{"apply", apply}}).candidates()) << apply;
    Renderer uniform(frame, technique("uniform"), technique("uniform").defaults);
    EXPECT_FALSE(uniform.candidates());
}

// Of one box's map, the texels that receivers within its volume project to, by the map's matrix in doubles.
TEST(TexelsReferenced, AreThoseThatReceiversProjectTo) {
    const gl::Context context = gl::Context::headless(-1);
    const scenegen::Scene scene = scenegen::loadScene("box");
    const gpuscene::GpuScene gpu(scene);
    const auto caster = std::ranges::find_if(scene.instances, [&](const scenegen::Instance& i) { return scene.prototypes[i.prototype].castsShadow; });
    std::vector<base::Box> boxes;
    for (const scenegen::Prototype& prototype : scene.prototypes) boxes.push_back(prototype.box());
    frame::Frame frame(gpu, scene.views.front(), 200, 150);
    for (const int size : {32, 128}) {
        Renderer renderer(frame, technique("instanced"), resolve(technique("instanced"), {{"size", std::to_string(size)}, {"mode", "exact"}}));
        frame::PassObserver silent;
        renderer.render(silent);
        const auto referenced = renderer.texelsReferenced();
        ASSERT_TRUE(referenced);
        const truth::Receivers receivers = frame.readReceivers();
        const glm::dmat4 clip = renderer.technique()->matrices().at(0).clipFromRelative;
        const double pad = 2 * 1.5 * glm::length(glm::dvec3(boxes[caster->prototype].size())) / size;
        std::vector<bool> surely(size_t(size) * size_t(size)), perhaps = surely;
        for (size_t i = 0; i < receivers.present.size(); ++i) {
            const glm::dvec3 p = glm::dvec3(receivers.position[i]) + frame.camera().eye;
            if (!receivers.present[i] || glm::dot(glm::dvec3(receivers.normal[i]), frame.light()) >= -1e-3) continue;
            if (boxesTowardsSun(scene, boxes, p, frame.light(), pad) == 0) continue;
            const glm::dvec3 q = (p - glm::dvec3(caster->translation)) / double(caster->scale);
            const glm::dvec2 texel = (glm::dvec2(clip * glm::dvec4(q, 1)) * 0.5 + 0.5) * double(size);
            const auto at = [&](const glm::dvec2& t) { return size_t(std::clamp(t.y, 0.0, size - 1.0)) * size_t(size) + size_t(std::clamp(t.x, 0.0, size - 1.0)); };
            perhaps[at(texel)] = true;
            const glm::dvec2 within = texel - glm::floor(texel);
            if (boxesTowardsSun(scene, boxes, p, frame.light(), 0) > 0 && glm::all(glm::greaterThan(within, glm::dvec2(0.02))) && glm::all(glm::lessThan(within, glm::dvec2(0.98)))) surely[at(texel)] = true;
        }
        EXPECT_GE(*referenced, size_t(std::ranges::count(surely, true)));
        EXPECT_LE(*referenced, size_t(1.02 * double(std::ranges::count(perhaps, true))) + 2);
        EXPECT_LE(*referenced, renderer.technique()->texelsInUse());
        EXPECT_GT(*referenced, size_t(size * size / 20));
        // A filter reads around them.
        Renderer wide(frame, technique("instanced"), resolve(technique("instanced"), {{"size", std::to_string(size)}, {"mode", "exact"}, {"filter", "pcf3"}}));
        EXPECT_GT(wide.texelsReferenced().value(), *referenced);
    }
    Renderer tiled(frame, technique("instanced"), resolve(technique("instanced"), {{"apply", "tiled"}}));
    EXPECT_FALSE(tiled.texelsReferenced());
}

}  // namespace
}  // namespace dapple::shadow
