#pragma once

#include "frame/frame.h"
#include "shadow/registry.h"
#include "visibility/hiz_culling.h"
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
    bool asksOcclusion() const { return view_ != nullptr; }

private:
    const frame::Frame& frame_;
    bool everything_;
    std::unique_ptr<visibility::ViewCulling> view_;
    std::unique_ptr<visibility::HizCulling> hiz_;
    gpuscene::DrawList list_;
};

}  // namespace dapple::shadow
