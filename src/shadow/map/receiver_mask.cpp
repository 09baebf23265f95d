#include "shadow/map/receiver_mask.h"

#include "shadow/families.h"
#include "visibility/gl_queries.h"

#include <algorithm>
#include <cmath>

namespace dapple::shadow {

using gpuscene::Bucket;

namespace {

/// Along a side. Coarser ones take neighbours for receivers: of city-vienna at scale 16, in cells of 8.6 m, an eighth more casters.
constexpr int kMostCells = 1024;

}  // namespace

ReceiverMask::ReceiverMask(const frame::Frame& frame, const gpuscene::Items& items, const Settings& settings, const gl::Texture& map, const std::vector<std::string>& lookupDefines)
    : frame_(frame), items_(items),
      kind_(settings.at("mask") == "scatter"    ? Kind::scatter
            : settings.at("mask") == "box"      ? Kind::box
            : settings.at("mask") == "geometry" ? Kind::geometry
            : settings.at("mask") == "fragment" ? Kind::fragment
                                                : Kind::fragmentOr),
      size_(map.width()), reach_(int(std::ceil(kernelRadius(settings) + 1))), nearest_(gl::makeSampler({})) {
    const int cells = std::min(size_, kMostCells);
    cells_ = gl::Texture(GL_R8, cells, cells, map.layers());
    for (int i = 0; i < map.layers(); ++i) masks_.push_back(cells_.view(i));
    if (settings.at("mask-test") == "stencil") stencil_ = gl::Program("passes/fullscreen.vert", "shadow/mask_stencil.frag");
    if (kind_ == Kind::scatter) {
        std::vector<std::string> defines = lookupDefines;
        defines.push_back("MASK");
        scatter_ = gl::Program::compute("shadow/map_receivers.comp", defines);
        return;
    }
    if (kind_ == Kind::box) {
        box_ = gl::Program("visibility/box.vert", "shadow/receiver_mask.frag");
        boxArray_ = gl::makeVertexArray();
        for (const GLuint attribute : {0u, 1u}) {
            glEnableVertexArrayAttrib(boxArray_.name(), attribute);
            glVertexArrayAttribFormat(boxArray_.name(), attribute, 3, GL_FLOAT, false, attribute * sizeof(glm::vec3));
            glVertexArrayAttribBinding(boxArray_.name(), attribute, 0);
        }
        glVertexArrayBindingDivisor(boxArray_.name(), 0, 1);
        for (const gl::Texture& mask : masks_) {
            const gl::Texture* colours[] = {&mask};
            targets_.push_back(gl::makeFramebuffer(colours, nullptr));
        }
        return;
    }
    texels_ = gl::Texture(GL_R8, size_, size_);
    const gl::Texture* colours[] = {&texels_};
    for (int i = 0; i < map.layers(); ++i) targets_.push_back(gl::makeFramebuffer(colours, &map, i));
    std::vector<std::string> defines{"POSITION"};
    if (kind_ != Kind::geometry) defines.push_back("TEST");
    if (frame.scene().has(Bucket::opaque)) opaque_ = gl::Program("shadow/map_depth.vert", "shadow/receiver_mask.frag", defines);
    defines.push_back("ALPHA_TEST");
    if (frame.scene().has(Bucket::alphaTested)) alpha_ = gl::Program("shadow/map_depth.vert", "shadow/receiver_mask.frag", defines);
    coarse_ = gl::Program::compute("shadow/coarse_mask.comp");
}

void ReceiverMask::scatter(measure::Ledger& tally) {
    const GLubyte none = 0;
    glClearTexImage(cells_.name(), 0, GL_RED, GL_UNSIGNED_BYTE, &none);
    scatter_.set("uCells", glm::vec2(cells_.width(), float(cells_.width()) / float(size_)));
    scatter_.use();
    frame_.bindGeometry();
    glBindImageTexture(0, cells_.name(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R8);
    glDispatchCompute(GLuint(frame_.camera().width + 15) / 16, GLuint(frame_.camera().height + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    ++tally.drawCalls;
}

void ReceiverMask::drawMasked(const gpuscene::DrawList& list, const glm::dmat4& clip, measure::Ledger& tally) {
    for (const gl::Program* program : {&opaque_, &alpha_})
        if (program->name()) frame_.setView(*program);
    frame_.bindGeometry();
    drawCasters(frame_.scene(), list, clip, opaque_, alpha_, tally);
}

void ReceiverMask::drawBoxes(const visibility::CullView& view, std::span<const uint32_t> items, measure::Ledger& tally) {
    std::vector<visibility::QueryBox> boxes;
    bool everywhere = false;
    for (const uint32_t i : items) {
        const base::DBox box = view.relative(items_.boxes()[i]);
        if (box.empty()) continue;
        if (view.certainlyVisible(box)) everywhere = true;
        else boxes.push_back(visibility::queryBox(view, box, size_, size_, reach_ + double(size_) / cells_.width()));
    }
    if (everywhere) {  // where such a box lies in the window is not known
        const float one[4] = {1, 1, 1, 1};
        glClearBufferfv(GL_COLOR, 0, one);
        return;
    }
    boxes_.update(boxes.size() * sizeof(visibility::QueryBox), boxes.data());
    glVertexArrayVertexBuffer(boxArray_.name(), 0, boxes_.name(), 0, sizeof(visibility::QueryBox));
    glBindVertexArray(boxArray_.name());
    box_.set("uClipFromRelative", glm::mat4(view.clipFromRelative));
    box_.use();
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, GLsizei(boxes.size()));
    ++tally.drawCalls;
}

void ReceiverMask::build(int layer, const gl::Framebuffer& mapTarget, const visibility::CullView& view, const Receivers& receivers, const gl::Program& depth,
                         const gl::Program& depthAlpha, measure::Ledger& tally) {
    const float zero[4] = {0, 0, 0, 0};
    if (kind_ == Kind::box) {
        glBindFramebuffer(GL_FRAMEBUFFER, targets_[size_t(layer)].name());
        glViewport(0, 0, cells_.width(), cells_.height());
        glClearBufferfv(GL_COLOR, 0, zero);
        glDisable(GL_DEPTH_TEST);
        drawBoxes(view, receivers.all, tally);
        glEnable(GL_DEPTH_TEST);
    } else if (kind_ != Kind::scatter) {
        glBindFramebuffer(GL_FRAMEBUFFER, targets_[size_t(layer)].name());
        glViewport(0, 0, size_, size_);
        glClearBufferfv(GL_COLOR, 0, zero);
        if (kind_ == Kind::fragment) {
            drawMasked(receivers.casters, view.clipFromRelative, tally);
        } else {  // any fragment counts, nearest or not
            glDisable(GL_DEPTH_TEST);
            glEnable(GL_BLEND);
            glBlendEquation(GL_MAX);
            drawMasked(receivers.casters, view.clipFromRelative, tally);
        }
        // What casts no shadow is not in the map, so that it cannot say which of it is nearest either.
        glDepthMask(GL_FALSE);
        glEnable(GL_BLEND);
        glBlendEquation(GL_MAX);
        drawMasked(receivers.others, view.clipFromRelative, tally);
        glDisable(GL_BLEND);
        glDepthMask(GL_TRUE);
        glEnable(GL_DEPTH_TEST);
        gl::finishTriangles();
        coarse_.set("uReach", reach_);
        coarse_.use();
        glBindTextureUnit(0, texels_.name());
        glBindSampler(0, nearest_.name());
        glBindImageTexture(0, masks_[size_t(layer)].name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8);
        const auto groups = GLuint(cells_.width() + 7) / 8;
        glDispatchCompute(groups, groups, 1);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, mapTarget.name());
    glViewport(0, 0, size_, size_);
    if (kind_ != Kind::fragment) drawCasters(frame_.scene(), receivers.casters, view.clipFromRelative, depth, depthAlpha, tally);
}

void ReceiverMask::markStencil(int layer) {
    const GLint zero = 0;
    glClearBufferiv(GL_STENCIL, 0, &zero);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, 1, 0xFF);
    glStencilOp(GL_KEEP, GL_REPLACE, GL_REPLACE);
    glDisable(GL_DEPTH_TEST);
    stencil_.set("uTexel", 1.0f / float(size_));
    stencil_.use();
    glBindTextureUnit(0, mask(layer).name());
    glBindSampler(0, nearest_.name());
    frame_.drawFullscreen();
    glEnable(GL_DEPTH_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_EQUAL, 1, 0xFF);
}

}  // namespace dapple::shadow
