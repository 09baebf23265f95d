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
        if (technique_) technique_->refresh();
    }
    /// False for `bare`, which has no visibility image.
    bool hasVisibility() const { return hasVisibility_; }
    /// V of the last render(), rows from the top; all lit where the technique is `unshadowed`.
    std::vector<float> visibility() const;
    std::string fallback() const;
    /// nullptr where no technique is needed (baselines of it, sun below the horizon).
    const Technique* technique() const { return technique_.get(); }
    /// Fragments per pixel of the technique's own screen-space work, or of the geometry where it has none.
    base::ImageF overdraw();
    /// Casters' volumes that hold each pixel's receiver; empty where the technique finds no candidate pixels.
    std::optional<base::ImageF> candidates();
    /// Texels of the technique's maps that a frame's look-ups read, each once. Nothing where it does not tell. Renders a frame.
    std::optional<size_t> texelsReferenced();
    size_t mapBytes() const { return technique_ ? technique_->mapBytes() : 0; }

private:
    frame::Frame& frame_;
    const TechniqueInfo& info_;
    std::optional<CameraCulling> camera_;
    frame::Lamps lamps_;
    bool hasVisibility_ = true, shadowed_ = true;
    std::string fallback_;
    std::unique_ptr<Technique> technique_;
    std::vector<frame::Pass> passes_;
};

}  // namespace dapple::shadow
