#pragma once

#include "frame/frame.h"
#include "shadow/registry.h"
#include "visibility/culling.h"

#include <memory>

/// Axes of visibility → what culls.
namespace dapple::shadow {

/// What may be drawn or left out as one, by axis `cluster`.
const gpuscene::Items& cullItems(const gpuscene::GpuScene& scene, const Settings& settings);

/// For an axis `camera` or `cull` with the value `method`; not pyramid. `sun`: casters alone, nearest with the least depth.
/// `pixels`: width and height of the view.
std::unique_ptr<visibility::Culling> makeCulling(const gpuscene::GpuScene& scene, const Settings& settings, const std::string& method, bool sun, const glm::ivec2& pixels);

/// Axis `camera`: what the G-buffer pass draws.
class CameraCulling {
public:
    CameraCulling(const frame::Frame& frame, const Settings& settings);

    /// For Frame::gbufferPass().
    frame::Frame::Culling culling();
    bool asksOcclusion() const { return statistics().has_value(); }
    std::optional<visibility::Statistics> statistics() const { return culling_->statistics(); }

private:
    const frame::Frame& frame_;
    bool everything_;
    std::unique_ptr<visibility::Culling> culling_;
};

}  // namespace dapple::shadow
