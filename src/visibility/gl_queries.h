#pragma once

#include "gl/program.h"
#include "visibility/occlusion_culler.h"

#include <epoxy/gl.h>

namespace dapple::visibility {

/// The pass that the queries are asked in. Framebuffer, viewport, depth test and its function are the caller's and are left alone.
struct QueryState {
    int width = 0, height = 0;  ///< of the viewport, pixels
    bool depthClamp = false;    ///< what end() restores: the renderer draws with it. Queries always do
    /// R8 or R32F in the clip space of the view, at most as fine as the viewport: samples where it is < ½ do not count.
    /// Bound to unit 0 (with its sampler) while asking. nullptr: none. A stencil test that the caller set up counts as well.
    const gl::Texture* mask = nullptr;
    /// Pixels by which boxes are enlarged: see queryBox(). ½ where queries and contents share one raster; 1 where the queries'
    /// is coarser.
    double margin = 0.5;
};

/// Occlusion queries of GL over boxes: ANY_SAMPLES_PASSED, or SAMPLES_PASSED for a threshold > 0. GL allows one such query at
/// a time, so that none may be active around it: frame::Pass::asksOcclusion says so to measure::Counters.
/// begin() sets colour and depth writes off, face culling and blending off, depth clamp on; end() sets both writes on, depth
/// clamp as told, and leaves face culling and blending off.
class GlQueries : public QueryDevice {
public:
    explicit GlQueries(uint64_t threshold = 0);
    ~GlQueries() override;
    GlQueries(const GlQueries&) = delete;
    GlQueries& operator=(const GlQueries&) = delete;

    /// For all queries from now on: the pass that is about to cull.
    void use(const QueryState& state);

    void begin() override;
    void end() override;
    Query issue(const gpuscene::Hierarchy& hierarchy, const CullView& view, std::span<const uint32_t> nodes) override;
    std::optional<uint64_t> poll(Query query) override;
    uint64_t wait(Query query) override;

private:
    const gl::Program& program() const { return state_.mask ? masked_ : plain_; }

    GLenum target_;
    QueryState state_;
    bool viewSet_ = false;  // of program(), since use()
    gl::Program plain_, masked_;
    gl::VertexArray vertexArray_;
    gl::Buffer boxes_;  // a stream: written front to back, then begun anew
    size_t used_ = 0;   // boxes
    gl::Sampler nearest_;
    std::vector<GLuint> free_, all_;  // of one target, to which GL ties a query object for life
};

/// One box as a query draws it: relative to the eye, enlarged.
struct QueryBox {
    glm::vec3 lo, hi;
};
static_assert(sizeof(QueryBox) == 24);

/// The box to rasterise for a node's, so that its samples hold all samples of what lies within, each at a depth that is no
/// farther. `pixels`: QueryState::margin.
QueryBox queryBox(const CullView& view, const base::DBox& relativeBox, int width, int height, double pixels);

}  // namespace dapple::visibility
