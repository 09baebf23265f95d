#include "visibility/receiver_pyramid.h"

#include <algorithm>
#include <bit>

namespace dapple::visibility {
namespace {

/// Finer cells find no fewer casters worth their cost: boxes are metres wide.
constexpr int kMostCells = 512;

}  // namespace

ReceiverPyramid::ReceiverPyramid(const gpuscene::GpuScene& scene, int mapSize, int layers)
    : table_(scene.instanceTable()), mapSize_(mapSize) {
    const auto cells = int(std::bit_floor(unsigned(std::min(mapSize, kMostCells))));
    levels_ = std::countr_zero(unsigned(cells)) + 1;
    pyramid_ = gl::Texture(GL_R32UI, cells, cells, layers, levels_);
    sampler_ = gl::makeSampler({});
    reduce_ = gl::Program::compute("visibility/max_level.comp");
    cull_ = gl::Program::compute("visibility/receiver_cull.comp", {"CELLS 8"});
}

void ReceiverPyramid::clear() {
    const GLuint none = 0;
    glClearTexImage(pyramid_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
}

void ReceiverPyramid::reduce() {
    reduce_.use();
    for (int level = 1; level < levels_; ++level) {
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        glBindImageTexture(0, pyramid_.name(), level - 1, GL_TRUE, 0, GL_READ_ONLY, GL_R32UI);
        glBindImageTexture(1, pyramid_.name(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32UI);
        const auto groups = GLuint(((cells() >> level) + 7) / 8);
        glDispatchCompute(groups, groups, GLuint(pyramid_.layers()));
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void ReceiverPyramid::choose(const Map& map, gpuscene::DrawList& list) const {
    table_.begin(list);
    table_.bind(list);
    cull_.set("uEye", map.eye);
    cull_.set("uInstances", int(table_.instances()));
    cull_.set("uLayer", map.layer);
    cull_.set("uLevels", levels_);
    cull_.set("uCells", float(cells()));
    cull_.set("uClip", glm::mat4(map.clipFromRelative));
    cull_.set("uLeastW", float(map.leastW));
    // A texel for the rasteriser's grid, and a part of a cell for what floats round of a place in it.
    cull_.set("uMargin", float(cells()) / float(mapSize_) + 1e-5f * float(cells()));
    cull_.set("uDepthSlack", 1e-5f);
    cull_.use();
    glBindTextureUnit(0, pyramid_.name());
    glBindSampler(0, sampler_.name());
    glDispatchCompute(GLuint(table_.instances() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace dapple::visibility
