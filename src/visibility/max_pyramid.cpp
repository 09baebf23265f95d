#include "visibility/max_pyramid.h"

#include <algorithm>
#include <bit>

namespace dapple::visibility {
namespace {

int squareOf(int width, int height) { return int(std::bit_ceil(unsigned(std::max(width, height)))); }

}  // namespace

MaxPyramid::MaxPyramid(GLenum format, int width, int height, int layers)
    : width_(width), height_(height), levels_(std::countr_zero(unsigned(squareOf(width, height))) + 1),
      texture_(format, squareOf(width, height), squareOf(width, height), layers, levels_), sampler_(gl::makeSampler({})),
      program_(gl::Program::compute("visibility/max_levels.comp", format == GL_R32F ? std::vector<std::string>{"FLOATS"} : std::vector<std::string>{})) {
    const GLuint none = 0;
    const GLfloat least = -1e30f;
    for (int level = 0; level < levels_; ++level)
        if (format == GL_R32F) glClearTexImage(texture_.name(), level, GL_RED, GL_FLOAT, &least);
        else glClearTexImage(texture_.name(), level, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
}

void MaxPyramid::reduce(int from) const {
    program_.use();
    for (int level = from; level < levels_ - 1; level += 2) {
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        for (int i = 0; i < 3; ++i)
            glBindImageTexture(GLuint(i), texture_.name(), std::min(level + i, levels_ - 1), GL_TRUE, 0, i == 0 ? GL_READ_ONLY : GL_WRITE_ONLY, texture_.format());
        const auto groups = [&](int cells) { return GLuint(((cells - 1) >> (level + 2)) / 8 + 1); };
        glDispatchCompute(groups(width_), groups(height_), GLuint(texture_.layers()));
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void MaxPyramid::setView(const gl::Program& program, const glm::dmat4& clipFromRelative, double leastW, const glm::vec2& pixels, float cellPixels, int finer) const {
    program.set("uClip", glm::mat4(clipFromRelative));
    program.set("uRelative", glm::mat4(glm::inverse(clipFromRelative)));
    program.set("uLeastW", float(leastW));
    program.set("uLevels", levels_ + finer);
    program.set("uCellsPerPixel", float(1 << finer) / cellPixels);
    program.set("uPixels", pixels);
}

void MaxPyramid::bind(GLuint unit) const {
    glBindTextureUnit(unit, texture_.name());
    glBindSampler(unit, sampler_.name());
}

}  // namespace dapple::visibility
