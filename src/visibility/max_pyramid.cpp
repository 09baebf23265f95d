#include "visibility/max_pyramid.h"

#include <bit>

namespace dapple::visibility {

MaxPyramid::MaxPyramid(GLenum format, int cells, int layers)
    : levels_(std::countr_zero(unsigned(cells)) + 1), texture_(format, cells, cells, layers, levels_), sampler_(gl::makeSampler({})),
      program_(gl::Program::compute("visibility/max_level.comp", format == GL_R32F ? std::vector<std::string>{"FLOATS"} : std::vector<std::string>{})) {}

void MaxPyramid::reduce() const {
    program_.use();
    for (int level = 1; level < levels_; ++level) {
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        glBindImageTexture(0, texture_.name(), level - 1, GL_TRUE, 0, GL_READ_ONLY, texture_.format());
        glBindImageTexture(1, texture_.name(), level, GL_TRUE, 0, GL_WRITE_ONLY, texture_.format());
        const auto groups = GLuint(((cells() >> level) + 7) / 8);
        glDispatchCompute(groups, groups, GLuint(texture_.layers()));
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void MaxPyramid::setCells(const gl::Program& program, const glm::vec2& pixels) const {
    program.set("uLevels", levels_);
    program.set("uCells", float(cells()));
    // A pixel is covered where its centre is: an eighth of it for vertices on the coarsest grid that GL allows, and what floats
    // round of a place.
    program.set("uMargin", 0.125f * float(cells()) / pixels + 1e-5f * float(cells()));
}

void MaxPyramid::bind(GLuint unit) const {
    glBindTextureUnit(unit, texture_.name());
    glBindSampler(unit, sampler_.name());
}

}  // namespace dapple::visibility
