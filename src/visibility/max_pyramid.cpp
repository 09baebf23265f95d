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

void MaxPyramid::setView(const gl::Program& program, const glm::dmat4& clipFromRelative, double leastW, const glm::vec2& pixels, int finer) const {
    program.set("uClip", glm::mat4(clipFromRelative));
    program.set("uRelative", glm::mat4(glm::inverse(clipFromRelative)));
    program.set("uLeastW", float(leastW));
    program.set("uLevels", levels_ + finer);
    program.set("uCells", float(cells() << finer));
    program.set("uPixels", pixels);
}

void MaxPyramid::bind(GLuint unit) const {
    glBindTextureUnit(unit, texture_.name());
    glBindSampler(unit, sampler_.name());
}

}  // namespace dapple::visibility
