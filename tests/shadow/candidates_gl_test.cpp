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

TEST_F(Candidates, AreThePixelsWhoseReceiverAVolumeHolds) {
    std::vector<base::Box> boxes;
    for (const scenegen::Prototype& prototype : scene_.prototypes) boxes.push_back(prototype.box());
    size_t inside = 0, outside = 0;
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
            if (!receivers.present[i]) {
                ASSERT_EQ(n, 0) << i;
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
    EXPECT_GT(inside, 5000u);
    EXPECT_GT(outside, 500u);
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

}  // namespace
}  // namespace dapple::shadow
