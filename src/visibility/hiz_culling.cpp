#include "visibility/hiz_culling.h"

namespace dapple::visibility {
namespace {

constexpr int kCells = 512;

}  // namespace

HizCulling::HizCulling(const gpuscene::Items& items, bool castersOnly, bool reversed)
    : table_(items.table(castersOnly)), reversed_(reversed), farthest_(GL_R32F, kCells, 1), nearest_(gl::makeSampler({})) {
    const std::vector<uint32_t> none(table_.size(), 0);
    visible_ = gl::Buffer::of<uint32_t>(none);
    const std::string sign = reversed ? "SIGN -1.0" : "SIGN 1.0";
    first_ = gl::Program::compute("visibility/hiz_cull.comp", {sign});
    second_ = gl::Program::compute("visibility/hiz_cull.comp", {sign, "SECOND"});
    cells_ = gl::Program::compute("visibility/depth_cells.comp", {sign});
}

void HizCulling::choose(const gl::Program& program, const ViewFrame& frame, gpuscene::DrawList& list) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, visible_.name());
    program.set("uLevels", farthest_.levels());
    program.set("uCells", float(farthest_.cells()));
    program.set("uClip", glm::mat4(frame.view.clipFromRelative));
    program.set("uLeastW", float(frame.leastW));
    // A pixel for the rasteriser's grid, and what floats round of a place.
    program.set("uMargin", glm::vec2(kCells) / glm::vec2(frame.depth->width(), frame.depth->height()) + 1e-5f * float(kCells));
    // A perspective depth is as good as its distance; an orthographic one as good as its range.
    program.set("uSlack", reversed_ ? glm::vec2(1e-4, 0) : glm::vec2(0, 1e-5));
    farthest_.bind(0);
    table_.choose(program, frame.view.eye, groups_, list);
}

void HizCulling::draw(const ViewFrame& frame, const gpuscene::Submit& submit) {
    table_.pick([&](const base::Box& box) { return frame.view.mayContain(frame.view.relative(box)); }, groups_);
    choose(first_, frame, lists_[0]);
    submit(lists_[0]);
    gl::finishTriangles();
    cells_.use();
    glBindTextureUnit(0, frame.depth->name());
    glBindSampler(0, nearest_.name());
    glBindImageTexture(0, farthest_.texture().name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute(kCells / 8, kCells / 8, 1);
    farthest_.reduce();
    choose(second_, frame, lists_[1]);
    submit(lists_[1]);
}

std::vector<uint32_t> HizCulling::drawn() const {
    std::vector<uint32_t> items;
    for (const gpuscene::DrawList& list : lists_) table_.read(list, items);
    return items;
}

}  // namespace dapple::visibility
