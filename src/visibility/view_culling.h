#pragma once

#include "gpuscene/gpu_scene.h"
#include "visibility/gl_queries.h"

#include <memory>

namespace dapple::visibility {

/// What one view, the camera's or a map's, draws of a scene, frame after frame: the instances in the leaves that coherent
/// hierarchical culling finds visible.
class ViewCulling {
public:
    struct Options {
        CullSettings settings;
        uint64_t leafTriangles = 10'000;  ///< of the hierarchy's leaves
        bool castersOnly = false;         ///< leave out what casts no shadow
    };
    ViewCulling(const gpuscene::GpuScene& scene, const Options& options);

    /// Draws into what is bound. `state`: the pass that queries are asked in. `drawn`: instances that the view has already, in
    /// a bit each; none is drawn again. Nothing: none.
    void draw(const CullView& view, const QueryState& state, const gpuscene::Submit& submit, const std::vector<bool>* drawn = nullptr);

    /// Drawn by the last draw(), in that order.
    const std::vector<uint32_t>& instances() const { return instances_; }

private:
    const gpuscene::GpuScene& scene_;
    const gpuscene::Hierarchy& hierarchy_;
    OcclusionCuller culler_;
    ViewState state_;
    GlQueries queries_;
    gpuscene::DrawList list_;
    std::vector<uint32_t> instances_;
};

}  // namespace dapple::visibility
