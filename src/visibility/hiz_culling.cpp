#include "visibility/hiz_culling.h"

#include <fmt/format.h>

#include <algorithm>

namespace dapple::visibility {
namespace {

constexpr int kMostCells = 1024;

/// A side of a cell of the pyramid's finest level, in pixels: 4 in a camera's view of over 512 pixels, where finer ones cost more to
/// make than they spare, else 2; in views of over 2048 pixels more.
int cellPixels(const HizCulling::Options& options) {
    const int longer = std::max(options.pixels.x, options.pixels.y);
    int side = options.reversed && longer > 512 ? 4 : 2;
    while (longer > kMostCells * side) side *= 2;
    return side;
}

}  // namespace

HizCulling::HizCulling(const gpuscene::Items& items, const Options& options)
    : table_(items.table(options.castersOnly)), reversed_(options.reversed), cellPixels_(cellPixels(options)),
      farthest_(GL_R32F, (options.pixels.x - 1) / cellPixels_ + 1, (options.pixels.y - 1) / cellPixels_ + 1, 1), nearest_(gl::makeSampler({})) {
    const std::vector<glm::uvec2> none(table_.size(), glm::uvec2(0));
    histories_ = gl::Buffer::of<glm::uvec2>(none);
    std::vector<std::string> defines{options.reversed ? "SIGN -1.0" : "SIGN 1.0"};
    cells_ = gl::Program::compute("visibility/depth_cells.comp", {defines[0], fmt::format("CELL {}", cellPixels_)});
    if (cellPixels_ == 2) defines.push_back("IMAGE_CELLS");
    first_ = gl::Program::compute("visibility/hiz_cull.comp", defines);
    defines.push_back("SECOND");
    second_ = gl::Program::compute("visibility/hiz_cull.comp", defines);
    defines.push_back("GROUPS");
    secondGroups_ = gl::Program::compute("visibility/hiz_cull.comp", defines);
}

void HizCulling::setUp(const gl::Program& program, const ViewFrame& frame) const {
    farthest_.setView(program, frame.view.clipFromRelative, frame.leastW, {frame.depth->width(), frame.depth->height()}, float(cellPixels_),
                      cellPixels_ == 2 ? 1 : 0);
    // A perspective depth is as good as its distance; an orthographic one as good as its range.
    program.set("uSlack", reversed_ ? glm::vec2(1e-4, 0) : glm::vec2(0, 1e-5));
    program.set("uFrame", frame_);
}

void HizCulling::draw(const ViewFrame& frame, const gpuscene::Submit& submit) {
    pickGroups(table_, frame.view, groups_);
    ++frame_;
    for (const gl::Program* program : {&first_, &secondGroups_, &second_}) setUp(*program, frame);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, histories_.name());
    table_.choose(nullptr, first_, frame.view.eye, groups_, lists_[0]);
    submit(lists_[0]);
    gl::finishTriangles();
    cells_.use();
    glBindTextureUnit(0, frame.depth->name());
    glBindSampler(0, nearest_.name());
    glBindImageTexture(0, farthest_.texture().name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute(GLuint(farthest_.width() + 7) / 8, GLuint(farthest_.height() + 7) / 8, 1);
    farthest_.reduce();
    farthest_.bind(0);
    glBindTextureUnit(1, frame.depth->name());
    glBindSampler(1, nearest_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, histories_.name());
    table_.choose(&secondGroups_, second_, frame.view.eye, groups_, lists_[1]);
    submit(lists_[1]);
}

std::vector<uint32_t> HizCulling::drawn() const {
    std::vector<uint32_t> items;
    for (const gpuscene::DrawList& list : lists_) table_.read(list, items);
    return items;
}

}  // namespace dapple::visibility
