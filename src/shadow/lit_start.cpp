#include "shadow/lit_start.h"

#include <fmt/format.h>

namespace dapple::shadow {

LitStart::LitStart(const frame::Frame& frame, Depth copy, std::optional<float> unlit) : frame_(frame), copy_(copy) {
    const bool attached = copy == Depth::tested || copy == Depth::withStencil;
    std::vector<std::string> defines;
    if (attached) defines.push_back("OWN_DEPTH");
    if (unlit) defines.push_back(fmt::format("UNLIT {:.1f}", *unlit));
    program_ = gl::Program("passes/fullscreen.vert", "shadow/lit_start.frag", defines);
    const GLenum format = copy == Depth::readable ? GL_R32F : copy == Depth::tested ? GL_DEPTH_COMPONENT32F : GL_DEPTH32F_STENCIL8;
    if (copy != Depth::none) depth_ = gl::Texture(format, frame.camera().width, frame.camera().height);
    const gl::Texture* colours[] = {&frame.visibility(), &depth_};
    target_ = gl::makeFramebuffer(std::span(colours, copy == Depth::readable ? 2 : 1), attached ? &depth_ : nullptr);
}

void LitStart::record(measure::Ledger& tally) const {
    glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
    glViewport(0, 0, frame_.camera().width, frame_.camera().height);
    if (copy_ == Depth::tested || copy_ == Depth::withStencil) {
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_ALWAYS);
    }
    if (copy_ == Depth::withStencil) {
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
