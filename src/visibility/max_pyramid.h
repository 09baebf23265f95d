#pragma once

#include "gl/program.h"

namespace dapple::visibility {

/// An array of images with all coarser levels, each cell of which is the largest of four of the next finer level.
class MaxPyramid {
public:
    MaxPyramid() = default;
    /// `width`, `height`: cells of level 0 that are used; its sides are the next power of two, and its other cells are and stay
    /// the least value. `format`: GL_R32UI or GL_R32F. Throws base::Error(failed): no memory.
    MaxPyramid(GLenum format, int width, int height, int layers);

    const gl::Texture& texture() const { return texture_; }
    int width() const { return width_; }
    int height() const { return height_; }
    int levels() const { return levels_; }
    /// Makes the levels coarser than `from`, which image stores have filled with all that are finer, and lets textures fetch from all.
    void reduce(int from = 0) const;
    /// Binds it to a texture unit.
    void bind(GLuint unit) const;
    /// Sets all but uSlack and uBeyond of lib/covered_cells.glsl, for what is drawn into an image of `pixels`. `leastW`: clip w up to which
    /// nothing is known of a box; `cellPixels`: a side of a cell of level 0, pixels; `finer`: levels before level 0 that the program
    /// has from elsewhere.
    void setView(const gl::Program& program, const glm::dmat4& clipFromRelative, double leastW, const glm::vec2& pixels, float cellPixels, int finer = 0) const;

private:
    int width_ = 0, height_ = 0, levels_ = 0;
    gl::Texture texture_;
    gl::Sampler sampler_;
    gl::Program program_;
};

}  // namespace dapple::visibility
