#include "visibility/hiz_culling.h"

namespace dapple::visibility {
namespace {

constexpr int kCells = 512;

}  // namespace

HizCulling::HizCulling(const gpuscene::GpuScene& scene, bool castersOnly, bool reversed)
    : table_(scene.instanceTable()), castersOnly_(castersOnly), reversed_(reversed), farthest_(GL_R32F, kCells, 1), nearest_(gl::makeSampler({})) {
    const std::vector<uint32_t> none(table_.instances(), 0);
    visible_ = gl::Buffer::of<uint32_t>(none);
    const std::string sign = reversed ? "SIGN -1.0" : "SIGN 1.0";
    first_ = gl::Program::compute("visibility/hiz_cull.comp", {sign});
    second_ = gl::Program::compute("visibility/hiz_cull.comp", {sign, "SECOND"});
    cells_ = gl::Program::compute("visibility/depth_cells.comp", {sign});
}

void HizCulling::choose(const gl::Program& program, const View& view, gpuscene::DrawList& list) {
    table_.begin(list);
    table_.bind(list);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, visible_.name());
    program.set("uEye", view.eye);
    program.set("uInstances", int(table_.instances()));
    program.set("uLevels", farthest_.levels());
    program.set("uCells", float(farthest_.cells()));
    program.set("uClip", glm::mat4(view.clipFromRelative));
    program.set("uLeastW", float(view.leastW));
    // A pixel for the rasteriser's grid, and what floats round of a place.
    program.set("uMargin", glm::vec2(kCells) / glm::vec2(view.depth.width(), view.depth.height()) + 1e-5f * float(kCells));
    // A perspective depth is as good as its distance; an orthographic one as good as its range.
    program.set("uSlack", reversed_ ? glm::vec2(1e-4, 0) : glm::vec2(0, 1e-5));
    program.set("uCasters", int(castersOnly_));
    program.use();
    farthest_.bind(0);
    glDispatchCompute(GLuint(table_.instances() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void HizCulling::draw(const View& view, const gpuscene::Submit& submit) {
    choose(first_, view, lists_[0]);
    submit(lists_[0]);
    gl::finishTriangles();
    cells_.use();
    glBindTextureUnit(0, view.depth.name());
    glBindSampler(0, nearest_.name());
    glBindImageTexture(0, farthest_.texture().name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute(kCells / 8, kCells / 8, 1);
    farthest_.reduce();
    choose(second_, view, lists_[1]);
    submit(lists_[1]);
}

gpuscene::InstanceTable::Drawn HizCulling::drawn() const {
    gpuscene::InstanceTable::Drawn sum = table_.read(lists_[0]);
    const gpuscene::InstanceTable::Drawn second = table_.read(lists_[1]);
    sum.instances += second.instances;
    sum.triangles += second.triangles;
    return sum;
}

}  // namespace dapple::visibility
