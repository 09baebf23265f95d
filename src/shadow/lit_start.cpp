#include "shadow/lit_start.h"

namespace dapple::shadow {

LitStart::LitStart(const frame::Frame& frame, Depth copy, bool spares) : frame_(frame), copy_(copy), spares_(spares) {
    const bool attached = copy == Depth::tested || copy == Depth::withStencil;
    std::vector<std::string> defines;
    if (attached) defines.push_back("OWN_DEPTH");
    if (spares) defines.push_back("UNLIT");
    program_ = gl::Program("passes/fullscreen.vert", "shadow/lit_start.frag", defines);
    const GLenum format = copy == Depth::readable ? GL_R32F : copy == Depth::tested ? GL_DEPTH_COMPONENT32F : GL_DEPTH32F_STENCIL8;
    if (copy != Depth::none) depth_ = gl::Texture(format, frame.camera().width, frame.camera().height);
    const gl::Texture* colours[] = {&frame.visibility(), &depth_};
    target_ = gl::makeFramebuffer(std::span(colours, copy == Depth::readable ? 2 : 1), attached ? &depth_ : nullptr);
}

void LitStart::record(measure::Ledger& tally) {
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
    draw(1, tally);
}

void LitStart::draw(float unlit, measure::Ledger& tally) {
    unlit_ = unlit;
    frame_.setView(program_);
    if (spares_) program_.set("uUnlit", unlit);
    program_.use();
    frame_.bindGeometry();
    frame_.drawFullscreen();
    ++tally.drawCalls;
}

void LitStart::setUnlit(float depth, measure::Ledger& tally) {
    if (!spares_ || depth == unlit_) return;
    GLint target = 0, function = 0;
    GLboolean colours[4], writesDepth = GL_FALSE;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
    glGetIntegerv(GL_DEPTH_FUNC, &function);
    glGetBooleanv(GL_COLOR_WRITEMASK, colours);
    glGetBooleanv(GL_DEPTH_WRITEMASK, &writesDepth);
    const bool culls = glIsEnabled(GL_CULL_FACE), tests = glIsEnabled(GL_STENCIL_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_ALWAYS);
    glDisable(GL_CULL_FACE);
    glDisable(GL_STENCIL_TEST);
    draw(depth, tally);
    ++tally.trianglesSubmitted;  // in a pass whose other triangles are counted
    glBindFramebuffer(GL_FRAMEBUFFER, GLuint(target));
    glColorMask(colours[0], colours[1], colours[2], colours[3]);
    glDepthMask(writesDepth);
    glDepthFunc(GLenum(function));
    if (culls) glEnable(GL_CULL_FACE);
    if (tests) glEnable(GL_STENCIL_TEST);
}

}  // namespace dapple::shadow
