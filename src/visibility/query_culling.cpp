#include "visibility/query_culling.h"

#include <algorithm>

namespace dapple::visibility {

QueryCulling::QueryCulling(const gpuscene::Items& items, const Options& options)
    : items_(items), hierarchy_(items.hierarchy(options.leafTriangles, options.castersOnly)), culler_(hierarchy_, options.settings),
      queries_(options.settings.threshold) {}

void QueryCulling::draw(const ViewFrame& frame, const gpuscene::Submit& submit) {
    struct Renderer final : LeafRenderer {
        Renderer(QueryCulling& c, const glm::dvec3& e, const gpuscene::Submit& s) : culling(c), eye(e), submit(s) {}
        void draw(std::span<const uint32_t> leaves) override {
            const size_t first = culling.drawn_.size();
            for (const uint32_t leaf : leaves)
                for (const uint32_t item : culling.hierarchy_.items(leaf))
                    if (!culling.hadBefore(item)) culling.drawn_.push_back(item);
            culling.items_.collect(eye, std::span(culling.drawn_).subspan(first), culling.list_);
            submit(culling.list_);
        }
        QueryCulling& culling;
        const glm::dvec3& eye;
        const gpuscene::Submit& submit;
    };
    drawn_.clear();
    ++frame_;
    if (!frame.drawn.empty()) drawnBefore_.resize(items_.size(), 0);
    for (const uint32_t item : frame.drawn) drawnBefore_[item] = frame_;
    queries_.use({.width = frame.depth->width(), .height = frame.depth->height(), .depthClamp = frame.depthClamp, .mask = frame.mask});
    Renderer renderer(*this, frame.view.eye, submit);
    AlreadyDrawn already;
    if (!frame.drawn.empty()) already = [&](uint32_t leaf) { return std::ranges::all_of(hierarchy_.items(leaf), [&](uint32_t item) { return hadBefore(item); }); };
    culler_.cull(frame.view, state_, queries_, renderer, already);
}

}  // namespace dapple::visibility
