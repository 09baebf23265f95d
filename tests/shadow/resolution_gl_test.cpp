// What maps are asked for, measured on the GPU, against rays through the corners of pixels in doubles; and a walk with it.
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/instanced/caster_list.h"
#include "shadow/instanced/resolution.h"
#include "shadow/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::shadow {
namespace {

class Resolution : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);
    frame::PassObserver silent_;

    static Settings settings(Settings axes) {
        axes.try_emplace("resolution", "estimate");
        return resolve(technique("instanced"), axes);
    }
};

/// Sum over every fourth pixel's receiver, within the shadow volume of the one box, of the texels that it asks for: a pixel's
/// corners cast onto its plane, and the map's scale along its axes.
double bruteForce(const frame::Frame& frame, const base::Box& box, const scenegen::Instance& instance) {
    const truth::Receivers receivers = frame.readReceivers();
    const frame::Camera& camera = frame.camera();
    const LightBasis basis = lightBasis(frame.light(), {0, 0, 1});
    base::DBox onLight;
    for (int corner = 0; corner < 8; ++corner) onLight.extend(basis.toLight(glm::dvec3(box.corner(corner))));
    const glm::dvec3 extent = 2.0 * onLight.halfSize() * double(instance.scale);
    const double grown = 1e-3 * glm::length(glm::dvec3(box.halfSize()));
    double sum = 0;
    for (int y = 2; y < camera.height; y += 4)
        for (int x = 2; x < camera.width; x += 4) {
            const size_t i = size_t(camera.height - 1 - y) * size_t(camera.width) + size_t(x);
            const glm::dvec3 p(receivers.position[i]), n(receivers.normal[i]);
            if (!receivers.present[i] || glm::dot(n, frame.light()) > -0.05) continue;
            const glm::dvec3 q = (p - (glm::dvec3(instance.translation) - camera.eye)) / double(instance.scale);
            double enter = 0, leave = 1e300;
            for (int k = 0; k < 3; ++k) {
                const double a = (q[k] - double(box.lo[k]) + grown) / frame.light()[k], b = (q[k] - double(box.hi[k]) - grown) / frame.light()[k];
                enter = std::max(enter, std::min(a, b));
                leave = std::min(leave, std::max(a, b));
            }
            if (enter > leave) continue;
            const auto onMap = [&](double dx, double dy) {
                const glm::dvec3 ray = camera.right * (((x + 0.5 + dx) / camera.width * 2 - 1) * camera.tanX) + camera.up * (((y + 0.5 + dy) / camera.height * 2 - 1) * camera.tanY) + camera.forward;
                const glm::dvec3 hit = ray * (glm::dot(n, p) / glm::dot(n, ray));
                return glm::dvec2(glm::dot(hit, basis.u) / extent.x, glm::dot(hit, basis.v) / extent.y);
            };
            const glm::dvec2 across = onMap(1e-4, 0) - onMap(-1e-4, 0), up = onMap(0, 1e-4) - onMap(0, -1e-4);
            // The shortest radius of the ellipse that the unit circle becomes, by walking round it.
            double shortest = 1e300;
            for (int k = 0; k < 720; ++k) shortest = std::min(shortest, glm::length(across * std::cos(k * 0.0043633) + up * std::sin(k * 0.0043633)));
            sum += 16 * std::min(2e-4 / shortest, 2048.0);
        }
    return sum;
}

TEST_F(Resolution, DemandIsThatOfRaysThroughPixels) {
    const scenegen::Scene scene = scenegen::loadScene("box");
    const gpuscene::GpuScene gpu(scene);
    const auto caster = std::ranges::find_if(scene.instances, [&](const scenegen::Instance& i) { return scene.prototypes[i.prototype].castsShadow; });
    for (const scenegen::View& view : scene.views) {
        frame::Frame frame(gpu, view, 320, 240);
        const std::vector<frame::Pass> gbuffer{frame.gbufferPass()};
        frame::execute(gbuffer, silent_);
        glFinish();  // llvmpipe's compute threads do not wait for the triangles before them
        const CasterMaps maps(frame, settings({{"mode", "nearest"}}));
        ASSERT_EQ(maps.maps().size(), 1u);
        CasterList casters(frame, maps);
        casters.collect();
        DemandEstimate estimate(frame, {"BIAS 1", "FILTER 0", "KERNEL 0.0", "SNAP 0.0", "MODE 0", "SAMPLE_FRAME 3"}, 2048);
        measure::Ledger ignored;
        estimate.record(1, [&](const gl::Program& program) {
            frame.setView(program);
            const double heading = sunAngles(frame.light()).heading;
            program.set("uHeading", glm::vec2(std::cos(heading), std::sin(heading)));
            program.set("uPadTexels", float(maps.padTexels()));
            program.set("uCasters", int(casters.size()));
            frame.bindGeometry();
            casters.bind();
            program.use();
        }, ignored);
        const double expected = bruteForce(frame, scene.prototypes[caster->prototype].box(), *caster);
        EXPECT_GT(expected, 1e5);
        EXPECT_NEAR(estimate.result(true).value().at(0) / expected, 1, 0.02) << view.name;
    }
}

// Maps of several sizes lie side by side: fewer texels than fixed ones take, and no look-up reads a neighbour, whose depths
// would show where one way to apply the maps asks outside of the volume and another does not.
TEST_F(Resolution, EveryWayToApplyTheMapsGivesTheSamePixels) {
    const scenegen::Scene scene = scenegen::loadScene("forest-small");
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), 160, 120);
    for (const char* filter : {"nearest", "pcf2", "pcf3"}) {
        std::vector<float> usual;
        for (const std::string apply : {"zpass", "zfail", "all", "skip", "tiled"}) {
            Renderer renderer(frame, technique("instanced"), settings({{"mode", "exact"}, {"filter", filter}, {"apply", apply}}));
            for (int i = 0; i < 3; ++i) renderer.render(silent_);
            EXPECT_LT(renderer.technique()->texelsInUse(), size_t(24 * 512 * 512) / 2);
            const std::vector<float> now = renderer.visibility();
            if (usual.empty()) usual = now;
            EXPECT_GT(std::ranges::count(now, 0.0f), 500);
            size_t different = 0;
            for (size_t i = 0; i < now.size(); ++i) different += now[i] != usual[i];
            EXPECT_EQ(different, 0u) << filter << " " << apply;
        }
    }
}

// Away and back again: sizes follow, and the maps that grew were rendered anew.
TEST_F(Resolution, FollowsAWalkAndSettles) {
    const scenegen::Scene scene = scenegen::loadScene("forest-small");
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), 160, 120);
    const Settings axes = settings({{"mode", "exact"}});
    Renderer walking(frame, technique("instanced"), axes);
    scenegen::View view = scene.views.front();
    const auto stay = [&](int frames) {
        size_t changes = 0, before = walking.technique()->texelsInUse();
        for (int i = 0; i < frames; ++i) {
            walking.render(silent_);
            glFinish();  // so that the next frame finds the measurement
            const size_t now = walking.technique()->texelsInUse();
            changes += now != before;
            before = now;
        }
        return changes;
    };
    EXPECT_EQ(stay(40), 0u) << "the first frame's sizes are those of its view";
    const size_t near = walking.technique()->texelsInUse();
    view.eye -= 60.0 * view.forward;
    frame.look(view);
    walking.replan();
    EXPECT_GT(stay(3 * SizeChooser::kPatience), 0u);
    const size_t far = walking.technique()->texelsInUse();
    EXPECT_LT(far, near);
    EXPECT_EQ(stay(2 * SizeChooser::kPatience), 0u);
    // Where it has settled each map has the side that a start there gives it, or, by hysteresis, half of it: which of the two is
    // its history's (SizeChooser.SettlesWithinItsHysteresisWhateverWasBefore).
    for (int walk = 0; walk < 2; ++walk) {
        frame.look(scene.views.front());
        walking.replan();
        EXPECT_GT(stay(4), 0u) << "grows at once";
        stay(3 * SizeChooser::kPatience);
        EXPECT_EQ(stay(2 * SizeChooser::kPatience), 0u);
        const size_t again = walking.technique()->texelsInUse();
        EXPECT_LE(again, near);
        EXPECT_GE(again, near / 4);
        EXPECT_GT(again, far);
        frame.look(view);
        walking.replan();
        stay(3 * SizeChooser::kPatience);
        EXPECT_EQ(stay(2 * SizeChooser::kPatience), 0u);
        EXPECT_LT(walking.technique()->texelsInUse(), again);
    }
}

// A map whose size changes is due whatever the policy is, beside a budget too: each shows what maps of every frame show.
TEST_F(Resolution, EveryUpdatePolicyRendersTheMapsWhoseSizeChanges) {
    const scenegen::Scene scene = scenegen::loadScene("forest-small");
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views.front(), 160, 120);
    scenegen::View away = scene.views.front();
    away.eye -= 60.0 * away.forward;
    std::vector<float> everyFrame;
    for (const char* update : {"regenerate", "cached", "criterion", "round-robin"}) {
        frame.look(away);
        Settings axes = settings({{"mode", "exact"}, {"update", update}});
        if (update == std::string("round-robin")) axes["budget"] = "1";
        Renderer renderer(frame, technique("instanced"), axes);
        const size_t far = renderer.technique()->texelsInUse();
        frame.look(scene.views.front());
        renderer.replan();
        for (int i = 0; i < 4; ++i) {
            renderer.render(silent_);
            glFinish();  // so that the next frame finds the measurement
        }
        EXPECT_GT(renderer.technique()->texelsInUse(), far) << update;
        if (everyFrame.empty()) everyFrame = renderer.visibility();
        EXPECT_GT(std::ranges::count(everyFrame, 0.0f), 500);
        EXPECT_EQ(renderer.visibility(), everyFrame) << update;
    }
}

// The casters are listed before the maps change where a far field chooses among them: their look-ups follow all the same.
TEST_F(Resolution, BesideAFarFieldLookUpsFollowInTheSameFrame) {
    const scenegen::Scene scene = scenegen::loadScene("forest-small");
    const gpuscene::GpuScene gpu(scene);
    scenegen::View away = scene.views.front();
    away.eye -= 60.0 * away.forward;
    frame::Frame frame(gpu, away, 160, 120);
    Renderer renderer(frame, technique("instanced"), settings({{"mode", "exact"}, {"far-field", "40"}}));
    frame.look(scene.views.front());
    renderer.replan();
    size_t changes = 0;
    for (int i = 0; i < 6; ++i) {
        const size_t before = renderer.technique()->texelsInUse();
        renderer.render(silent_);
        const std::vector<float> now = renderer.visibility();
        const bool changed = renderer.technique()->texelsInUse() != before;
        renderer.render(silent_);
        if (!changed || renderer.technique()->texelsInUse() == before) continue;
        ++changes;
        EXPECT_EQ(renderer.visibility(), now);
    }
    EXPECT_GT(changes, 0u);
}

}  // namespace
}  // namespace dapple::shadow
