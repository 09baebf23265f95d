#include "visibility/receiver_pyramid.h"

#include <algorithm>
#include <bit>

namespace dapple::visibility {
namespace {

/// Finer cells find no fewer casters worth their cost: boxes are metres wide.
constexpr int kMostCells = 1024;

}  // namespace

ReceiverPyramid::ReceiverPyramid(int mapSize, int layers, bool warped)
    : mapSize_(mapSize), pyramid_(GL_R32UI, int(std::bit_floor(unsigned(std::min(mapSize, kMostCells)))), layers) {
    cull_ = gl::Program::compute("visibility/receiver_cull.comp", warped ? std::vector<std::string>{"WARPED"} : std::vector<std::string>{});
}

void ReceiverPyramid::clear() {
    const GLuint none = 0;
    glClearTexImage(texture().name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
}

void ReceiverPyramid::choose(const gpuscene::ItemTable& table, const gpuscene::ItemTable::Groups& groups, int layer, const ViewFrame& frame, gpuscene::DrawList& list) const {
    cull_.set("uLayer", layer);
    cull_.set("uClip", glm::mat4(frame.view.clipFromRelative));
    cull_.set("uLeastW", float(frame.leastW));
    pyramid_.setCells(cull_, glm::vec2(float(mapSize_)));
    cull_.set("uSlack", glm::vec2(0, 1e-5f));
    pyramid_.bind(0);
    table.choose(cull_, frame.view.eye, groups, list);
}

void PyramidCulling::draw(const ViewFrame& frame, const gpuscene::Submit& submit) {
    table_.pick([&](const base::Box& box) { return frame.view.mayContain(frame.view.relative(box)); }, groups_);
    pyramid_.choose(table_, groups_, layer_, frame, list_);
    submit(list_);
}

std::vector<uint32_t> PyramidCulling::drawn() const {
    std::vector<uint32_t> items;
    table_.read(list_, items);
    return items;
}

}  // namespace dapple::visibility
