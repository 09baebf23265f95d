#pragma once

#include "frame/frame.h"

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
    /// `spares`: the copy is to fail the tests of what comes next where no light can arrive, at the sky and at surfaces that face
    /// away from the sun. Throws base::Error(failed) when there is no memory for the copy.
    LitStart(const frame::Frame& frame, Depth copy, bool spares = false);
    void record(measure::Ledger& tally);
    /// Of a copy that spares: its depth there from now on; 1 fails GL_GREATER, as record() leaves it, and 0 GL_LESS. Draws only
    /// where that changes it. GL's state stays but for textures, program and vertex array.
    void setUnlit(float depth, measure::Ledger& tally);
    const gl::Texture& depth() const { return depth_; }

private:
    void draw(float unlit, measure::Ledger& tally);

    const frame::Frame& frame_;
    Depth copy_;
    bool spares_;
    float unlit_ = 1;
    gl::Texture depth_;
    gl::Framebuffer target_;
    gl::Program program_;
};

}  // namespace dapple::shadow
