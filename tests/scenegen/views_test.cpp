#include "scenegen/city/assembly.h"
#include "scenegen/city/solid.h"
#include "scenegen/import/auto_views.h"
#include "scenegen/views/pick_views.h"
#include "scenegen/views/quick_render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

/// Boxes on a ground plate whose top is at z = 0.
class Boxes {
public:
    explicit Boxes(double groundSize) { add({-0.5 * groundSize, -0.5 * groundSize, -1}, {0.5 * groundSize, 0.5 * groundSize, 0}, false); }
    void add(const glm::dvec3& lo, const glm::dvec3& hi, bool caster = true) {
        Mesh mesh;
        city::addBox(mesh, lo, hi);
        const uint32_t material = city::addMaterial(scene, "m", glm::vec3(0.5f));
        mesh.material = material;
        city::addInstance(scene, city::addPrototype(scene, "box", {mesh}, caster), glm::dvec3(0), {1, 0});
    }
    Scene scene;
};

View from(const glm::dvec3& eye, const glm::dvec3& target) {
    View view;
    view.eye = eye;
    view.forward = glm::normalize(target - eye);
    if (std::abs(view.forward.z) > 0.99) view.up = {0, 1, 0};
    return view;
}

TEST(QuickRender, SharesEqualClosedForms) {
    Boxes boxes(100);
    boxes.add({-20, -20, 0}, {20, 20, 1});
    boxes.scene.sun = {.azimuth = 90, .elevation = 5};
    const QuickRender render(boxes.scene);
    const Sight sight = render.look(from({0, 0, 100}, {0, 0, 0}));
    // Share of the picture that a square metre of ground takes.
    const double perMetre = 1 / (std::pow(2 * 100 * std::tan(glm::radians(30.0)), 2) * 64 / 48);
    const double shadow = 40 / std::tan(glm::radians(5.0)) * perMetre;  // 40 m wide, 11.4 m long
    EXPECT_NEAR(sight.shadowed, shadow, 0.1 * shadow);
    EXPECT_NEAR(sight.sky, 1 - 1e4 * perMetre, 0.02);  // a column of pixels
    EXPECT_NEAR(sight.lit, 1e4 * perMetre - shadow, 0.02);
    EXPECT_NEAR(sight.casters, 0, 0.005);  // from above no wall is in sight
}

TEST(QuickRender, AWallBeforeTheEyeIsNear) {
    Boxes boxes(100);
    boxes.add({-50, 2, 0}, {50, 3, 50});
    const QuickRender render(boxes.scene);
    EXPECT_GT(render.look(from({0, 0, 1.7}, {0, 1, 1.7})).near, 0.5);
    EXPECT_EQ(render.look(from({0, 0, 1.7}, {0, -1, 1.7})).near, 0);
    EXPECT_EQ(render.look(from({0, 0, 1.7}, {0, -20, 20})).sky, 1);
}

TEST(PickViews, PrefersShadowsToWallsAndSkyAndSpreads) {
    Boxes boxes(200);
    for (int i = 0; i < 5; ++i) boxes.add({-40 + 20 * i, 20, 0}, {-34 + 20 * i, 26, 12});
    boxes.scene.sun = {.azimuth = 0, .elevation = 30};  // shadows fall towards the eye
    const View good = from({0, -20, 1.7}, {0, 20, 1.7}), beside = from({1, -20, 1.7}, {0, 20, 1.7}), wall = from({-37, 17, 1.7}, {-37, 20, 1.7}),
               sky = from({0, -60, 1.7}, {0, -60, 50}), bare = from({0, -30, 1.7}, {0, -90, 1.7});
    const std::vector<View> picked = pickViews(boxes.scene, {sky, wall, beside, bare, good}, 4);
    ASSERT_FALSE(picked.empty());
    EXPECT_NEAR(picked[0].eye.y, -20, 1e-9);
    EXPECT_EQ(std::ranges::count_if(picked, [](const View& v) { return v.eye.y == -20; }), 1) << "two views from one spot";
    for (const View& view : picked) EXPECT_TRUE(view.eye != sky.eye && view.eye != bare.eye);
}

TEST(ChooseViews, SeeCastersAndShadowsWhereverTheyStand) {
    // A wood of posts in one corner of a wide plain, and a low "sea" around: most spots see nothing.
    Boxes boxes(800);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) boxes.add({200 + 18 * x, 200 + 17 * y, 0}, {203 + 18 * x, 203 + 17 * y, 9});
    const std::vector<View> views = chooseViews(boxes.scene);
    const QuickRender render(boxes.scene);
    ASSERT_GE(views.size(), 4u);
    for (size_t i = 0; i < views.size(); ++i) {
        if (!views[i].name.starts_with("auto")) continue;
        const Sight sight = render.look(views[i]);
        EXPECT_GT(sight.casters, 0.02) << views[i].name;
        EXPECT_GT(sight.shadowed, 0.005) << views[i].name;
        EXPECT_LT(sight.near, 0.3) << views[i].name;
        for (size_t k = 0; k < i; ++k) EXPECT_GT(glm::distance(views[i].eye, views[k].eye), 5) << views[i].name;
    }
}

}  // namespace
}  // namespace dapple::scenegen
