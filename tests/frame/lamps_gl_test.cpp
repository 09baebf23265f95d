#include "frame/lamps.h"

#include "frame/yard.h"
#include "gl/context.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::frame {
namespace {

constexpr int kWidth = 160, kHeight = 120;

double linear(uint8_t srgb) {
    const double v = srgb / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

struct Night : ::testing::Test {
    Night() : context(gl::Context::headless()), scene(yard(12)) {
        scene.sun.elevation = -20;
        scene.materials[kGround].albedo = scene.materials[kBox].albedo = glm::vec3(0.36f);  // the G-buffer keeps its root, 0.6, exactly
    }
    ~Night() override { EXPECT_NO_THROW(gl::checkErrors("test")); }

    base::Image8 picture(truth::Receivers* receivers = nullptr) {
        const gpuscene::GpuScene gpu(scene);
        Frame frame(gpu, scene.views[0], kWidth, kHeight);
        Lamps lamps(frame);
        const std::vector<Pass> passes{frame.gbufferPass(), frame.shadePass(false), lamps.pass()};
        leftOut = passes.back().leftOut;
        PassObserver silent;
        execute(passes, silent);
        if (receivers) *receivers = frame.readReceivers();
        return frame.readShaded();
    }

    gl::Context context;
    scenegen::Scene scene;
    std::string leftOut;
};

TEST_F(Night, WithoutLampsThePassIsLeftOut) {
    picture();
    EXPECT_EQ(leftOut, "the scene has no local light");
}

// Oracle: the formulas of KHR_lights_punctual in doubles, at the receivers that the G-buffer holds.
TEST_F(Night, LampsLightAsTheFormulaSays) {
    const base::Image8 dark = picture();
    const glm::vec3 eye(scene.views[0].eye);
    const scenegen::LocalLight outside{{3, -5, 3.5f}, {0, 0, -1}, {9, 9, 9}, 12, 0.3f, 1.2f};
    scenegen::LocalLight bare{eye + glm::vec3(0, 2, 0.5f), {0, 0, -1}, {15, 15, 15}, 12};  // the eye is within its range
    for (const scenegen::LocalLight& light : {outside, bare}) {
        scene.lights = {light};
        truth::Receivers receivers;
        const base::Image8 lit = picture(&receivers);
        EXPECT_EQ(leftOut, "");
        int brighter = 0;
        double worst = 0;
        for (size_t i = 0; i < receivers.present.size(); ++i) {
            const double seen = linear(lit.texels[3 * i]) - linear(dark.texels[3 * i]);
            if (!receivers.present[i]) {
                EXPECT_EQ(lit.texels[3 * i], dark.texels[3 * i]) << "the sky is lit";
                continue;
            }
            const glm::dvec3 toLamp = glm::dvec3(light.position) - scene.views[0].eye - glm::dvec3(receivers.position[i]);
            const double d = glm::length(toLamp), cosine = glm::dot(-toLamp / d, glm::dvec3(light.direction));
            double expected = 0;
            if (d < double(light.range)) {
                const double window = 1 - std::pow(d / double(light.range), 4), outer = std::cos(double(light.outerAngle));
                const double cone = light.outerAngle < 3.14f ? std::clamp((cosine - outer) / (std::cos(double(light.innerAngle)) - outer), 0.0, 1.0) : 1;
                expected = 0.36 * double(light.intensity.x) * std::max(0.0, glm::dot(glm::dvec3(receivers.normal[i]), toLamp / d)) * window * cone * cone / (d * d);
            }
            if (seen >= 0.99 || linear(lit.texels[3 * i]) > 0.95) continue;  // clipped
            // The fences' texels have colours of their own; one step of 8-bit sRGB is up to 0.009 in linear light.
            const glm::dvec3 at = scene.views[0].eye + glm::dvec3(receivers.position[i]);
            const bool fence = at.y < -8.5 && at.z > 0.05;
            if (!fence) worst = std::max(worst, std::abs(seen - expected));
            brighter += seen > 0.03;
        }
        EXPECT_LT(worst, 0.012);
        EXPECT_GT(brighter, 500);
    }
}

TEST_F(Night, TheSkyDarkensWithTheSun) {
    const auto sky = [&](double elevation) {
        scene.sun.elevation = elevation;
        return linear(picture().texels[2]);
    };
    const double day = sky(5);
    EXPECT_EQ(sky(0), day) << "no step at the horizon";
    EXPECT_NEAR(sky(-6) / day, 0.5, 0.02);
    EXPECT_EQ(sky(-12), sky(-40)) << "night is night";
    EXPECT_GT(sky(-40), 0);
}

}  // namespace
}  // namespace dapple::frame
