#pragma once

#include "bench/stage.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <algorithm>

/// Images of a technique along views that jump, for tests of what must not change them.
namespace dapple::bench {

inline constexpr int kWidth = 160, kHeight = 120;

/// A scene at test size, walked through with jumps: each view, twice the first, so that coherence has something to hold on to.
struct Walk : Stage {
    Walk(const std::string& name, const std::vector<std::string>& settings) : Walk(scenegen::loadScene(name, settings)) {}
    explicit Walk(scenegen::Scene made)
        : Stage(std::move(made), kWidth, kHeight) {
        for (size_t i = 0; i < std::min<size_t>(scene.views.size(), 3); ++i) views.push_back(scene.views[i]);
        views.insert(views.begin(), views.front());
    }

    struct Image {
        std::vector<float> visibility, depth;
        bool operator==(const Image&) const = default;
    };
    /// One renderer, image after image; its first frame sees a cut like all others.
    std::vector<Image> images(const std::string& technique, shadow::Settings axes) {
        if (technique != "unshadowed") axes.try_emplace("size", "256");
        const shadow::TechniqueInfo& info = shadow::technique(technique);
        const shadow::Settings settings = shadow::resolve(info, axes);
        EXPECT_FALSE(shadow::pruneReason(info, settings, gpu.facts(), workbench().limits()));
        frame.look(views.front());
        shadow::Renderer renderer(frame, info, settings);
        std::vector<Image> result;
        frame::PassObserver silent;
        for (const scenegen::View& view : views) {
            frame.look(view);
            renderer.replan();
            renderer.render(silent);
            result.push_back({renderer.visibility(), frame.readChannel(frame.depth()).texels});
        }
        drawn = renderer.technique() ? renderer.technique()->castersDrawn() : std::nullopt;
        matrices = renderer.technique() ? renderer.technique()->matrices() : std::vector<shadow::LightMatrix>{};
        gl::checkErrors("a walk");
        return result;
    }

    std::vector<scenegen::View> views;
    std::optional<shadow::Technique::Casters> drawn;  // of the last image
    std::vector<shadow::LightMatrix> matrices;
};

inline std::string text(const shadow::Settings& axes) {
    std::string text;
    for (const auto& [axis, value] : axes) text += " " + axis + "=" + value;
    return text;
}

inline size_t differences(const std::vector<Walk::Image>& a, const std::vector<Walk::Image>& b) {
    size_t count = 0;
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t p = 0; p < a[i].visibility.size(); ++p) count += a[i].visibility[p] != b[i].visibility[p];
    return count;
}

/// Methods that must give what cull none gives.
inline const std::vector<shadow::Settings> kExact{{{"cull", "frustum"}},
                                           {{"cull", "chc"}},
                                           {{"cull", "chcpp"}, {"leaf", "600"}, {"batch", "4"}},
                                           {{"cull", "receivers"}},
                                           {{"cull", "receivers"}, {"camera", "chcpp"}, {"mask-test", "stencil"}},
                                           {{"cull", "receivers"}, {"camera", "chc"}, {"mask", "box"}},
                                           {{"cull", "hiz"}},
                                           {{"cull", "pyramid"}, {"camera", "hiz"}},
                                           {{"cull", "frustum"}, {"cluster", "300"}},
                                           {{"cull", "receivers"}, {"camera", "chcpp"}, {"cluster", "300"}, {"leaf", "500"}},
                                           {{"cull", "hiz"}, {"cluster", "300"}},
                                           {{"cull", "pyramid"}, {"camera", "hiz"}, {"cluster", "60"}}};

inline void expectSamePixels(Walk& walk, const std::string& technique, const shadow::Settings& sampling, const std::vector<shadow::Settings>& methods = kExact) {
    shadow::Settings all = sampling;
    all["cull"] = "none";
    const std::vector<Walk::Image> truth = walk.images(technique, all);
    for (shadow::Settings axes : methods) {
        SCOPED_TRACE(technique + text(sampling) + text(axes));
        for (const auto& [axis, value] : sampling) axes[axis] = value;
        EXPECT_EQ(differences(walk.images(technique, axes), truth), 0u);
    }
}

}  // namespace dapple::bench
