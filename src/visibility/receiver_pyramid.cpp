#include "visibility/receiver_pyramid.h"

#include <algorithm>
#include <bit>

namespace dapple::visibility {
namespace {

/// Finer cells find no fewer casters worth their cost: boxes are metres wide.
constexpr int kMostCells = 1024;

}  // namespace

ReceiverPyramid::ReceiverPyramid(const gpuscene::GpuScene& scene, int mapSize, int layers, bool warped)
    : table_(scene.instanceTable()), mapSize_(mapSize), pyramid_(GL_R32UI, int(std::bit_floor(unsigned(std::min(mapSize, kMostCells)))), layers) {
    cull_ = gl::Program::compute("visibility/receiver_cull.comp", warped ? std::vector<std::string>{"CELLS 16", "WARPED"} : std::vector<std::string>{"CELLS 16"});
}

void ReceiverPyramid::clear() {
    const GLuint none = 0;
    glClearTexImage(texture().name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
}

void ReceiverPyramid::choose(const Map& map, gpuscene::DrawList& list) const {
    table_.begin(list);
    table_.bind(list);
    cull_.set("uEye", map.eye);
    cull_.set("uInstances", int(table_.instances()));
    cull_.set("uLayer", map.layer);
    cull_.set("uLevels", pyramid_.levels());
    cull_.set("uCells", float(cells()));
    cull_.set("uClip", glm::mat4(map.clipFromRelative));
    cull_.set("uLeastW", float(map.leastW));
    // A texel for the rasteriser's grid, and a part of a cell for what floats round of a place in it.
    cull_.set("uMargin", float(cells()) / float(mapSize_) + 1e-5f * float(cells()));
    cull_.set("uDepthSlack", 1e-5f);
    cull_.use();
    pyramid_.bind(0);
    glDispatchCompute(GLuint(table_.instances() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace dapple::visibility
