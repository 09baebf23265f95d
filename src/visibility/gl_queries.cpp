#include "visibility/gl_queries.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace dapple::visibility {
namespace {

constexpr size_t kStreamBoxes = 1 << 14;
constexpr GLsizei kBoxVertices = 36;

}  // namespace

// Why no false "invisible" comes of it. Let a triangle within the box cover the sample s of a pixel. Rasterisers snap vertices
// to a grid of at least 1/16 pixel (GL's minimum; 1/256 is common) after transforming them in float: the triangle's exact
// image need not cover s, but it has a point p within that error of s on the image, and the depth at s is that of such a p.
// p lies in the box. Enlarging the box by e in all directions of the world, with e the length that ½ pixel spans at most in it
// (8 grid steps of the coarsest rasteriser: the box's own vertices are snapped as well), makes its image hold a disc of ½ pixel
// about p's image, which holds s with room to spare, however thin, flat or far below a pixel the box was. Its image is covered
// without gaps, since it is closed and its faces share their vertices. And the ray through s enters the enlarged box before p:
// by e less that error, some 10⁻³ of the distance where a pixel is 10⁻³ radians, whereas depths are interpolated to 10⁻⁶: its
// nearest fragment at s is no farther than the triangle's, and where that would have passed, this one does. Quantising to 16
// or 24 bits keeps the order. Depth clamp keeps the front of a box that the enlargement pushes through the near plane.
QueryBox queryBox(const CullView& view, const base::DBox& box, int width, int height, double pixels) {
    const double reach = glm::length(glm::max(glm::abs(box.lo), glm::abs(box.hi)));
    // What floats round, and for a map along a sun that stands far off, what its depth rounds.
    double e = pixels * view.footprint(box, width, height) + 2e-6 * reach;
    if (view.parallel) {
        const glm::dvec3 z(view.clipFromRelative[0][2], view.clipFromRelative[1][2], view.clipFromRelative[2][2]);
        const double perMetre = std::abs(glm::dot(z, view.axis));
        if (perMetre > 0) e += 1e-6 / perMetre;
    }
    // Outwards, so that the rounding to float takes nothing back.
    return {glm::vec3(box.lo - e - 1e-7 * glm::abs(box.lo)), glm::vec3(box.hi + e + 1e-7 * glm::abs(box.hi))};
}

GlQueries::GlQueries(uint64_t threshold)
    : target_(threshold > 0 ? GL_SAMPLES_PASSED : GL_ANY_SAMPLES_PASSED), plain_("visibility/box.vert", "visibility/box.frag"),
      masked_("visibility/box.vert", "visibility/box.frag", {"MASKED"}), vertexArray_(gl::makeVertexArray()),
      boxes_(kStreamBoxes * sizeof(QueryBox), nullptr, true), nearest_(gl::makeSampler({})) {
    for (const GLuint attribute : {0u, 1u}) {
        glEnableVertexArrayAttrib(vertexArray_.name(), attribute);
        glVertexArrayAttribFormat(vertexArray_.name(), attribute, 3, GL_FLOAT, false, attribute * sizeof(glm::vec3));
        glVertexArrayAttribBinding(vertexArray_.name(), attribute, 0);
    }
    glVertexArrayBindingDivisor(vertexArray_.name(), 0, 1);
}

GlQueries::~GlQueries() { glDeleteQueries(GLsizei(all_.size()), all_.data()); }

void GlQueries::use(const QueryState& state) {
    assert(state.width > 0 && state.height > 0);
    state_ = state;
    viewSet_ = false;
}

void GlQueries::begin() {
    program().use();
    if (state_.mask) {
        glBindTextureUnit(0, state_.mask->name());
        glBindSampler(0, nearest_.name());
    }
    glBindVertexArray(vertexArray_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_CLAMP);
}

void GlQueries::end() {
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    (state_.depthClamp ? glEnable : glDisable)(GL_DEPTH_CLAMP);
}

Query GlQueries::issue(const gpuscene::Hierarchy& hierarchy, const CullView& view, std::span<const uint32_t> nodes) {
    std::vector<QueryBox> boxes;
    boxes.reserve(nodes.size());
    for (const uint32_t n : nodes) boxes.push_back(queryBox(view, view.relative(hierarchy.nodes()[n].box), state_.width, state_.height, state_.margin));
    if (free_.empty()) {
        GLuint query = 0;
        glCreateQueries(target_, 1, &query);
        all_.push_back(query);
        free_.push_back(query);
    }
    const GLuint query = free_.back();
    free_.pop_back();
    const size_t capacity = boxes_.bytes() / sizeof(QueryBox);
    if (used_ + boxes.size() > capacity) {  // new storage: what is under way keeps the old
        boxes_ = gl::Buffer(std::max(kStreamBoxes, boxes.size()) * sizeof(QueryBox), nullptr, true);
        used_ = 0;
    }
    glNamedBufferSubData(boxes_.name(), GLintptr(used_ * sizeof(QueryBox)), GLsizeiptr(boxes.size() * sizeof(QueryBox)), boxes.data());
    glVertexArrayVertexBuffer(vertexArray_.name(), 0, boxes_.name(), GLintptr(used_ * sizeof(QueryBox)), sizeof(QueryBox));
    used_ += boxes.size();
    if (!viewSet_) {  // once a pass: a name is looked up slowly
        program().set("uClipFromRelative", glm::mat4(view.clipFromRelative));
        program().set("uPixel", glm::vec2(1.0 / state_.width, 1.0 / state_.height));
        viewSet_ = true;
    }
    glBeginQuery(target_, query);
    glDrawArraysInstanced(GL_TRIANGLES, 0, kBoxVertices, GLsizei(boxes.size()));
    glEndQuery(target_);
    return Query(query);
}

std::optional<uint64_t> GlQueries::poll(Query query) {
    GLuint available = GL_FALSE;
    glGetQueryObjectuiv(GLuint(query), GL_QUERY_RESULT_AVAILABLE, &available);
    if (!available) return {};
    return wait(query);
}

uint64_t GlQueries::wait(Query query) {
    GLuint64 samples = 0;
    glGetQueryObjectui64v(GLuint(query), GL_QUERY_RESULT, &samples);
    free_.push_back(GLuint(query));
    return samples;
}

}  // namespace dapple::visibility
