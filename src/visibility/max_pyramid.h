#pragma once

#include "gl/program.h"

namespace dapple::visibility {

/// An array of square images with all coarser levels, each cell of which is the largest of four of the next finer level.
class MaxPyramid {
public:
    MaxPyramid() = default;
    /// `cells`: along a side of level 0, a power of two; `format`: GL_R32UI or GL_R32F. Throws base::Error(failed): no memory.
    MaxPyramid(GLenum format, int cells, int layers);

    const gl::Texture& texture() const { return texture_; }
    int cells() const { return texture_.width(); }
    int levels() const { return levels_; }
    /// Makes the coarser levels from level 0, which image stores have filled, and lets textures fetch from all.
    void reduce() const;
    /// Binds it to a texture unit.
    void bind(GLuint unit) const;
    /// Sets all but uSlack of lib/covered_cells.glsl, for what is drawn into an image of `pixels`. `leastW`: clip w up to which
    /// nothing is known of a box; `finer`: levels before level 0 that the program has from elsewhere.
    void setView(const gl::Program& program, const glm::dmat4& clipFromRelative, double leastW, const glm::vec2& pixels, int finer = 0) const;

private:
    int levels_ = 0;
    gl::Texture texture_;
    gl::Sampler sampler_;
    gl::Program program_;
};

}  // namespace dapple::visibility
