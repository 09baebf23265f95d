#pragma once

#include "frame/lamps.h"
#include "shadow/culling.h"
#include "shadow/technique.h"

#include <optional>

namespace dapple::shadow {

/// A whole frame of one technique: the frame's own passes and the technique's between them, less what the scene
/// does not need.
class Renderer {
public:
    Renderer(frame::Frame& frame, const TechniqueInfo& info, const Settings& settings);

    /// Decides anew which passes are needed; after the frame's camera has moved.
    void replan();
    /// All passes, those left out included, in order.
    const std::vector<frame::Pass>& passes() const { return passes_; }
    void render(frame::PassObserver& observer) { frame::execute(passes_, observer); }

    /// Renders what the technique keeps from frame to frame for the frame's present sun, outside of any frame.
    void refresh() {
        for (size_t sun = 0; sun < techniques_.size(); ++sun)
            if (techniques_[sun]) forSun(sun, [&] { techniques_[sun]->refresh(); });
    }
    /// False for `bare`, which has no visibility image.
    bool hasVisibility() const { return hasVisibility_; }
    /// V of the last render() for a sun, rows from the top; all lit where the technique is `unshadowed`.
    std::vector<float> visibility(size_t sun = 0) const;
    std::string fallback() const;
    /// Of a sun, each of which has maps of its own; nullptr where none is needed (baselines of it, sun below the horizon).
    const Technique* technique(size_t sun = 0) const { return techniques_[sun].get(); }
    size_t suns() const { return techniques_.size(); }
    /// Technique::redrawCasters() of the first sun's.
    bool redrawCasters(size_t matrix, const gpuscene::Submit& submit) { return techniques_[0] && techniques_[0]->redrawCasters(matrix, submit); }
    /// Fragments per pixel of the geometry that the camera sees.
    base::ImageF geometryOverdraw();
    /// Fragments per pixel of the technique's shadow volumes; empty where it draws none.
    std::optional<base::ImageF> volumeOverdraw();
    /// Casters' volumes that hold each pixel's receiver; empty where the technique finds no candidate pixels.
    std::optional<base::ImageF> candidates();
    /// As Technique::queryStatistics(), with the camera's.
    std::vector<std::pair<std::string, visibility::Statistics>> queryStatistics() const;
    /// Texels of the suns' maps that a frame's look-ups read, each once. Nothing where the technique does not tell. Renders a frame.
    std::optional<size_t> texelsReferenced();
    size_t mapBytes() const;

private:
    template <class Work>
    void forSun(size_t sun, const Work& work) const {
        const frame::OfSun guard(frame_, sun);
        work();
    }
    void addPassesOf(size_t sun);
    std::optional<base::ImageF> counted(bool (Technique::*count)());  ///< the suns' counts together

    frame::Frame& frame_;
    const TechniqueInfo& info_;
    std::optional<CameraCulling> camera_;
    frame::Lamps lamps_;
    bool hasVisibility_ = true, shadowed_ = true;
    std::vector<std::unique_ptr<Technique>> techniques_;  ///< by sun
    std::vector<frame::Pass> passes_;
};

}  // namespace dapple::shadow
