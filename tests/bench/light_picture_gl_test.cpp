// Pictures of what the sun sees, against what culling says that it drew.
#include "base/error.h"
#include "bench/light_picture.h"
#include "bench/stage.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::bench {
namespace {

struct Shown {
    size_t leftOut = 0, drawn = 0, contributing = 0, receivers = 0;
    std::vector<float> visibility;
};

PointSpec spec(const std::string& technique, const std::string& cull, const std::string& size = "1024") {
    PointSpec s;
    s.scene = "city-vienna", s.sceneSettings = {"scale=0.05"}, s.technique = technique, s.view = "walk0";
    s.width = 160, s.height = 120;
    s.settings = shadow::resolve(shadow::technique(technique), {{"size", size}, {"cull", cull}});
    return s;
}

Shown casters(const std::string& cull, const std::string& size = "1024") {
    const PointSpec s = spec("uniform", cull, size);
    const auto shared = workbench().sharedFrame(s);
    shadow::Renderer renderer(shared->frame, shadow::technique("uniform"), s.settings);
    frame::PassObserver silent;
    for (int i = 0; i < 2; ++i) renderer.render(silent);
    const base::Image8 picture = paintCastersDrawn(*shared, renderer);
    Shown shown;
    shown.visibility = renderer.visibility();
    for (size_t i = 0; i < picture.texels.size(); i += 3) {
        const int r = picture.texels[i], g = picture.texels[i + 1], b = picture.texels[i + 2];
        if (r == g && g == b) ++shown.leftOut;
        else if (r > b && g > 230) ++shown.receivers;
        else if (r > b) ++shown.drawn;
        else if (b > 60) ++shown.contributing;
    }
    return shown;
}

TEST(LightPicture, ShowsWhatEachMethodLeavesOut) {
    const Shown none = casters("none"), frustum = casters("frustum"), pyramid = casters("pyramid");
    EXPECT_EQ(none.leftOut, 0u);
    EXPECT_GT(frustum.leftOut, 0u);
    EXPECT_GT(pyramid.leftOut, frustum.leftOut);
    EXPECT_GT(pyramid.receivers, 0u);
    // All that matters is drawn, whatever the method; but a caster that covers no centre of the texels that receivers look up is in
    // their rays' way and not in the map: the fewer, the finer the map.
    EXPECT_GT(none.contributing, 0u);
    EXPECT_EQ(frustum.contributing, none.contributing);
    EXPECT_LE(pyramid.contributing, none.contributing);
    EXPECT_EQ(pyramid.visibility, none.visibility);
    EXPECT_GT(double(casters("pyramid", "4096").contributing), 0.999 * double(casters("none", "4096").contributing));
}

TEST(LightPicture, MasksAreOfThoseThatAsk) {
    for (const char* cull : {"receivers", "pyramid", "frustum"}) {
        const auto shared = workbench().sharedFrame(spec("cascaded", cull));
        shadow::Renderer renderer(shared->frame, shadow::technique("cascaded"), spec("cascaded", cull).settings);
        frame::PassObserver silent;
        renderer.render(silent);
        if (std::string(cull) == "frustum") {
            EXPECT_THROW(paintReceiverMasks(*shared, renderer), base::UsageError);
            continue;
        }
        const base::Image8 picture = paintReceiverMasks(*shared, renderer);
        EXPECT_GE(picture.width, 256);
        size_t yellow = 0;
        for (size_t i = 0; i < picture.texels.size(); i += 3) yellow += picture.texels[i] > picture.texels[i + 2] + 60;
        EXPECT_GT(yellow, 20u) << cull;
    }
    const auto shared = workbench().sharedFrame(spec("uniform", "none"));
    shadow::Renderer renderer(shared->frame, shadow::technique("unshadowed"), shadow::technique("unshadowed").defaults);
    EXPECT_THROW(paintCastersDrawn(*shared, renderer), base::UsageError);
}

}  // namespace
}  // namespace dapple::bench
