#pragma once

#include "frame/frame.h"

#include <optional>

namespace dapple::shadow {

/// Start of the visibility image for techniques that darken it afterwards: lit and valid where the surface faces the sun,
/// with a copy of the frame's depth for what comes next.
class LitStart {
public:
    enum class Depth {
        none,
        readable,     ///< R32F, to read while the frame's own is tested against
        tested,       ///< D32F, to test against
        withStencil,  ///< the same with 8 stencil bits; record() clears them
    };
    /// `unlit`: what the copy holds where no light can arrive, at the sky and at surfaces that face away from the sun, instead of
    /// the depth there. Throws base::Error(failed) when there is no memory for the copy.
    LitStart(const frame::Frame& frame, Depth copy, std::optional<float> unlit = {});
    void record(measure::Ledger& tally) const;
    const gl::Texture& depth() const { return depth_; }

private:
    const frame::Frame& frame_;
    Depth copy_;
    gl::Texture depth_;
    gl::Framebuffer target_;
    gl::Program program_;
};

}  // namespace dapple::shadow
