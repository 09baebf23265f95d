#include "frame/frame.h"

#include "frame/yard.h"
#include "gl/context.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::frame {
namespace {

constexpr int kWidth = 320, kHeight = 240;

struct Picture {
    truth::Receivers receivers;
    base::Image8 shaded;
    measure::Ledger ledger;  ///< of the geometry pass
};

struct FirstLedger : PassObserver {
    std::vector<measure::Ledger> ledgers;
    void endPass(const Pass&, const measure::Ledger& ledger) override { ledgers.push_back(ledger); }
};

Picture draw(Frame& frame, bool bare = false) {
    std::vector<Pass> passes;
    if (bare) passes.push_back(frame.barePass());
    else passes = {frame.gbufferPass(), frame.shadePass(false)};
    FirstLedger observer;
    execute(passes, observer);
    return {frame.readReceivers(), frame.readShaded(), observer.ledgers.front()};
}
Picture draw(const scenegen::Scene& scene, const scenegen::View& view, bool bare = false) {
    const gpuscene::GpuScene gpu(scene);
    Frame frame(gpu, view, kWidth, kHeight);
    return draw(frame, bare);
}

class FrameTest : public ::testing::Test {
protected:
    FrameTest() : context_(gl::Context::headless()) {}
    ~FrameTest() override { EXPECT_NO_THROW(gl::checkErrors("test")); }
    gl::Context context_;
};

double angleDegrees(const glm::dvec3& a, const glm::dvec3& b) { return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b))); }

TEST_F(FrameTest, GBufferAgreesWithABruteForceRayCaster) {
    const scenegen::Scene scene = yard(40);
    const scenegen::View& view = scene.views[0];
    const truth::Receivers receivers = draw(scene, view).receivers;
    const RayCaster caster(scene, view.eye);
    std::vector<Hit> hits;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) hits.push_back(caster.closest(pixelRay(view, kWidth, kHeight, x, y)));

    int tested = 0, near = 0, aligned = 0, sky = 0;
    for (int y = 1; y < kHeight - 1; ++y)
        for (int x = 1; x < kWidth - 1; ++x) {
            const size_t i = size_t(y * kWidth + x);
            const auto same = [&](size_t other) {
                return std::isinf(hits[other].distance) == std::isinf(hits[i].distance) && hits[other].surface == hits[i].surface;
            };
            bool silhouette = false;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) silhouette |= !same(i + size_t(dy * kWidth + dx));
            if (silhouette) continue;
            if (std::isinf(hits[i].distance)) {
                EXPECT_FALSE(receivers.present[i]) << x << ", " << y;
                ++sky;
                continue;
            }
            ++tested;
            if (!receivers.present[i]) continue;
            const glm::dvec3 expected = pixelRay(view, kWidth, kHeight, x, y) * hits[i].distance;
            near += glm::distance(glm::dvec3(receivers.position[i]), expected) < 1e-3 * glm::length(expected);
            aligned += angleDegrees(glm::dvec3(receivers.normal[i]), hits[i].normal) < 1;
        }
    EXPECT_GT(tested, kWidth * kHeight / 3);
    EXPECT_GT(sky, kWidth * kHeight / 10);
    EXPECT_GE(near, 0.995 * tested) << tested;
    EXPECT_GE(aligned, 0.995 * tested) << tested;
}

TEST_F(FrameTest, AlphaTestedTexelsAreAbsentExactlyBelowTheCutoff) {
    scenegen::Scene scene = yard(0);
    scene.views[0].eye = {0.3, -13.5, 1.4};  // the fences fill the picture
    const scenegen::View& view = scene.views[0];
    const truth::Receivers receivers = draw(scene, view).receivers;
    const RayCaster caster(scene, view.eye);
    int present = 0, absent = 0, wrong = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const glm::dvec3 ray = pixelRay(view, kWidth, kHeight, x, y);
            const Hit hit = caster.closest(ray, true);
            if (hit.surface < 100 || std::isinf(hit.distance)) continue;  // the ground is instance 0
            // Vertices are snapped to 1/256 pixel, and a texel is about 10 pixels wide: 2 % of a texel either way.
            const glm::dvec2 texel = hit.uv * 8.0, fromEdge = glm::abs(texel - glm::round(texel));
            if (std::min(fromEdge.x, fromEdge.y) < 0.02) continue;
            const bool opaque = caster.alpha(kFence, hit.uv) >= 0.5;
            const size_t i = size_t(y * kWidth + x);
            const glm::dvec3 expected = ray * hit.distance;
            const bool drawn = receivers.present[i] && glm::distance(glm::dvec3(receivers.position[i]), expected) < 1e-3 * glm::length(expected);
            (opaque ? present : absent) += 1;
            wrong += drawn != opaque;
        }
    EXPECT_GT(present, 2000);
    EXPECT_GT(absent, 2000);
    EXPECT_EQ(wrong, 0);
}

TEST_F(FrameTest, CullingChangesNoPixel) {
    scenegen::Scene scene = yard(400);
    for (scenegen::Material& material : scene.materials) material.doubleSided = true;  // boxes that `near` cuts show their inside
    base::Random random(5, 0, 0);
    for (int i = 0; i < 6; ++i) {
        scenegen::View view = scene.views[0];
        view.eye = {random.next(-20, 20), random.next(-20, 20), random.next(0.5f, 6)};
        view.forward = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-0.3f, 0.1f)));
        view.fovY = 40;
        view.near = 1.5;  // cuts boxes
        view.far = 25;
        const Picture culled = draw(scene, view), bare = draw(scene, view, true);
        EXPECT_EQ(culled.receivers.present, bare.receivers.present);
        EXPECT_TRUE(culled.receivers.position == bare.receivers.position);
        EXPECT_GT(std::count(culled.receivers.present.begin(), culled.receivers.present.end(), 1), 1000);
        EXPECT_LT(culled.ledger.trianglesSubmitted, bare.ledger.trianglesSubmitted / 2);
        EXPECT_EQ(bare.ledger.trianglesSubmitted, 400u * 12 + 3 * 2);
    }
}

TEST_F(FrameTest, LookMovesEveryPass) {
    const scenegen::Scene scene = yard(40);
    scenegen::View other = scene.views[0];
    other.eye += glm::dvec3(2, 1, 0.5);
    const gpuscene::GpuScene gpu(scene);
    for (const bool bare : {false, true}) {
        Frame moved(gpu, scene.views[0], kWidth, kHeight);
        const Picture before = draw(moved, bare);
        moved.look(other);
        const Picture after = draw(moved, bare), expected = draw(scene, other, bare);
        EXPECT_TRUE(after.receivers.position == expected.receivers.position) << bare;
        EXPECT_TRUE(after.shaded.texels == expected.shaded.texels) << bare;
        EXPECT_FALSE(after.shaded.texels == before.shaded.texels);
    }
}

/// The yard of a renderer that adds up world coordinates in floats before it subtracts the eye.
scenegen::Scene naive(scenegen::Scene scene, const glm::dvec3& origin) {
    for (scenegen::Instance& instance : scene.instances) instance.translation += glm::vec3(origin);
    for (scenegen::View& view : scene.views) view.eye += origin;
    return scene;
}

TEST_F(FrameTest, AThousandKilometresAwayTheBitsAreTheSame) {
    const glm::dvec3 origin(1e6, -1e6, 300);
    const scenegen::Scene here = yard(40);
    scenegen::Scene there = here;
    there.origin = origin;
    const Picture a = draw(here, here.views[0]), b = draw(there, there.views[0]);
    EXPECT_EQ(a.receivers.present, b.receivers.present);
    EXPECT_TRUE(a.receivers.position == b.receivers.position);
    EXPECT_TRUE(a.receivers.normal == b.receivers.normal);
    EXPECT_TRUE(a.shaded.texels == b.shaded.texels);

    const scenegen::Scene control = naive(here, origin);
    const Picture c = draw(control, control.views[0]);
    EXPECT_FALSE(a.receivers.position == c.receivers.position);
    EXPECT_FALSE(a.shaded.texels == c.shaded.texels);
}

TEST_F(FrameTest, OverdrawCountsEveryLayerOfDepth) {
    scenegen::Scene scene = yard(0);
    scene.instances.resize(1);  // the ground alone: one layer where it is seen, none in the sky
    const gpuscene::GpuScene gpu(scene);
    Frame frame(gpu, scene.views[0], kWidth, kHeight);
    const Picture picture = draw(frame);
    frame.countGeometry();
    const base::ImageF counts = frame.readChannel(frame.overdraw());
    for (size_t i = 0; i < counts.texels.size(); ++i) ASSERT_EQ(counts.texels[i], float(picture.receivers.present[i]));
}

TEST_F(FrameTest, AnEmptySceneIsSky) {
    scenegen::Scene scene = yard(0);
    scene.instances.clear();
    const Picture picture = draw(scene, scene.views[0]);
    EXPECT_EQ(std::count(picture.receivers.present.begin(), picture.receivers.present.end(), 0), kWidth * kHeight);
    EXPECT_EQ(picture.ledger.drawCalls, 0u);
    EXPECT_GT(*std::min_element(picture.shaded.texels.begin(), picture.shaded.texels.end()), 100);  // light blue all over
}

}  // namespace
}  // namespace dapple::frame
