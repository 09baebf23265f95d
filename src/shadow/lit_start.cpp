#include "shadow/lit_start.h"

namespace dapple::shadow {

LitStart::LitStart(const frame::Frame& frame, Depth copy)
    : frame_(frame), copy_(copy),
      program_("passes/fullscreen.vert", "shadow/lit_start.frag", copy == Depth::withStencil ? std::vector<std::string>{"OWN_DEPTH"} : std::vector<std::string>{}) {
    const bool stencil = copy == Depth::withStencil;
    if (copy != Depth::none) depth_ = gl::Texture(stencil ? GL_DEPTH32F_STENCIL8 : GL_R32F, frame.camera().width, frame.camera().height);
    const gl::Texture* colours[] = {&frame.visibility(), &depth_};
    target_ = gl::makeFramebuffer(std::span(colours, copy == Depth::readable ? 2 : 1), stencil ? &depth_ : nullptr);
}

void LitStart::record(measure::Ledger& tally) const {
    glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
    glViewport(0, 0, frame_.camera().width, frame_.camera().height);
    if (copy_ == Depth::withStencil) {
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_ALWAYS);
        const GLint zero = 0;
        glClearBufferiv(GL_STENCIL, 0, &zero);
    }
    frame_.setView(program_);
    program_.use();
    frame_.bindGeometry();
    frame_.drawFullscreen();
    ++tally.drawCalls;
}

}  // namespace dapple::shadow
