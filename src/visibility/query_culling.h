#pragma once

#include "visibility/culling.h"
#include "visibility/gl_queries.h"

namespace dapple::visibility {

/// The items in the leaves that coherent hierarchical culling finds visible.
class QueryCulling final : public Culling {
public:
    struct Options {
        CullSettings settings;
        uint64_t leafTriangles = gpuscene::Items::kLeafTriangles;  ///< of the hierarchy's leaves
        bool castersOnly = false;         ///< leave out what casts no shadow
    };
    QueryCulling(const gpuscene::Items& items, const Options& options);

    void draw(const ViewFrame& frame, const gpuscene::Submit& submit) override;
    std::vector<uint32_t> drawn() const override { return drawn_; }
    std::optional<Statistics> statistics() const override { return culler_.statistics(); }

private:
    bool hadBefore(uint32_t item) const { return !drawnBefore_.empty() && drawnBefore_[item] == frame_; }

    const gpuscene::Items& items_;
    const gpuscene::Hierarchy& hierarchy_;
    OcclusionCuller culler_;
    ViewState state_;
    GlQueries queries_;
    gpuscene::DrawList list_;
    std::vector<uint32_t> drawn_;
    std::vector<uint32_t> drawnBefore_;  // by item: the last frame in which the view had it already
    uint32_t frame_ = 0;
};

}  // namespace dapple::visibility
