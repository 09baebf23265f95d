// However pixels and casters find each other, and however their shadows add up, instanced maps give one image, bit for bit.
#include "gl/context.h"
#include "scenegen/library.h"
#include "shadow/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::shadow {
namespace {

class Apply : public testing::Test {
protected:
    gl::Context context_ = gl::Context::headless(-1);

    struct Image {
        std::vector<float> visibility;
        std::vector<uint8_t> validity;
    };
    Image render(frame::Frame& frame, const Settings& settings) {
        Renderer renderer(frame, technique("instanced"), settings);
        frame::PassObserver silent;
        renderer.render(silent);
        return {renderer.visibility(), frame.readValidity()};
    }

    /// All settings that differ from `settings` in these axes alone and can run on the scene.
    std::vector<Settings> products(const Settings& settings, const scenegen::Facts& facts, const std::vector<std::string>& names) {
        std::vector<Settings> all{settings};
        for (const std::string& name : names) {
            std::vector<Settings> more;
            for (const Settings& known : all)
                for (const Axis::Value& value : axis(name).values) {
                    more.push_back(known);
                    more.back()[name] = value.name;
                }
            all = std::move(more);
        }
        std::erase_if(all, [&](const Settings& s) { return pruneReason(technique("instanced"), s, facts, {}).has_value(); });
        return all;
    }

    static size_t different(const std::vector<float>& a, const std::vector<float>& b) {
        size_t count = 0;
        for (size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
        return count;
    }

    static std::string text(const Settings& settings) {
        std::string text;
        for (const char* name : {"filter", "mode", "sample-frame", "accumulate", "apply", "cull"}) text += std::string(name) + "=" + settings.at(name) + " ";
        return text;
    }
};

// Every look-up of the registry, in every way to apply it: rotated trees and such that stand as their maps do, seen from outside
// of their volumes (walk0) and from within some (walk1).
TEST_F(Apply, EveryWayGivesTheSamePixels) {
    struct Case {
        const char *sun, *view;
        bool turned;
    };
    for (const Case& c : {Case{"sun.elevation=10", "walk1", true}, Case{"sun.elevation=80", "walk0", false}}) {
        SCOPED_TRACE(std::string(c.sun) + " " + c.view);
        scenegen::Scene scene = scenegen::loadScene("forest-small", {c.sun});
        for (scenegen::Instance& instance : scene.instances) instance.yaw *= c.turned;
        const gpuscene::GpuScene gpu(scene);
        frame::Frame frame(gpu, scene.views[scene.viewIndex(c.view)], 80, 60);
        const Settings small = resolve(technique("instanced"), {{"size", "64"}});
        size_t compared = 0, dark = 0, partly = 0;
        for (const Settings& look : products(small, scene.facts(), {"filter", "mode", "sample-frame", "accumulate"})) {
            const Image base = render(frame, look);
            for (const float v : base.visibility) dark += v == 0, partly += v > 0 && v < 1;
            for (const Settings& way : products(look, scene.facts(), {"apply", "cull"})) {
                if (way == look) continue;
                ++compared;
                const Image other = render(frame, way);
                EXPECT_EQ(different(base.visibility, other.visibility), 0u) << text(way);
                EXPECT_EQ(base.validity, other.validity) << text(way);
            }
            if (look.at("filter") != "nearest" || look.at("mode") == "blend" || look.at("accumulate") == "min") continue;
            Settings darkest = look;  // of shadows that are whole, each way to add them up gives the darkest
            darkest["accumulate"] = "min";
            EXPECT_EQ(different(base.visibility, render(frame, darkest).visibility), 0u) << text(look);
        }
        EXPECT_GT(compared, 200u);
        EXPECT_GT(dark, 5000u);
        EXPECT_GT(partly, 5000u);
    }
}

// A map of another rotation may darken what lies beside the caster's own shadow volume; only the test spares that.
TEST_F(Apply, SkippingTheTestWithRotatedMapsIsRefused) {
    const TechniqueInfo& info = technique("instanced");
    scenegen::Facts facts;
    facts.rotated = true;
    const auto refused = [&](const Settings& axes) { return pruneReason(info, resolve(info, axes), facts, {}).has_value(); };
    EXPECT_TRUE(refused({{"apply", "skip"}}));
    EXPECT_FALSE(refused({{"apply", "skip"}, {"mode", "exact"}}));
    facts.rotated = false;
    EXPECT_FALSE(refused({{"apply", "skip"}}));
    // The reason, seen: a low sun, and frame B, which turns the sun with the map.
    const scenegen::Scene scene = scenegen::loadScene("forest-small", {"sun.elevation=1"});
    const gpuscene::GpuScene gpu(scene);
    frame::Frame frame(gpu, scene.views[scene.viewIndex("walk2")], 160, 120);
    Settings settings = resolve(info, {{"size", "64"}, {"sample-frame", "B"}});
    const Image tested = render(frame, settings);
    settings["apply"] = "skip";
    const Image skipped = render(frame, settings);
    size_t darker = 0;
    for (size_t i = 0; i < tested.visibility.size(); ++i) {
        EXPECT_LE(skipped.visibility[i], tested.visibility[i]);
        darker += skipped.visibility[i] < tested.visibility[i];
    }
    EXPECT_GT(darker, 50u);
}

}  // namespace
}  // namespace dapple::shadow
