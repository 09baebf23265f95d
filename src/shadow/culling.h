#pragma once

#include "frame/frame.h"
#include "shadow/registry.h"
#include "visibility/view_culling.h"

#include <memory>

/// Axes of visibility → what culls.
namespace dapple::shadow {

/// For an axis `camera` or `cull` with the value `method`: chc, chcpp or receivers.
visibility::ViewCulling::Options cullOptions(const Settings& settings, const std::string& method, bool castersOnly);

/// Axis `camera`: what the G-buffer pass draws.
class CameraCulling {
public:
    CameraCulling(const frame::Frame& frame, const Settings& settings);
    /// For Frame::gbufferPass(); empty where the frame's own serves.
    frame::Frame::Culling culling();
    /// nullptr unless occlusion queries decide.
    const visibility::Statistics* statistics() const { return view_ ? &view_->statistics() : nullptr; }

private:
    const frame::Frame& frame_;
    bool everything_;
    std::unique_ptr<visibility::ViewCulling> view_;
    gpuscene::DrawList list_;
};

}  // namespace dapple::shadow
