#include "visibility/view_culling.h"

#include <algorithm>

namespace dapple::visibility {

ViewCulling::ViewCulling(const gpuscene::GpuScene& scene, const Options& options)
    : scene_(scene), hierarchy_(scene.hierarchy(options.leafTriangles, options.castersOnly)), culler_(hierarchy_, options.settings),
      queries_(options.settings.threshold) {}

void ViewCulling::draw(const CullView& view, const QueryState& state, const gpuscene::Submit& submit, const std::vector<bool>* drawn) {
    struct Renderer final : LeafRenderer {
        Renderer(ViewCulling& c, const CullView& v, const gpuscene::Submit& s, const std::vector<bool>* d) : culling(c), view(v), submit(s), drawn(d) {}
        void draw(std::span<const uint32_t> leaves) override {
            const size_t first = culling.instances_.size();
            for (const uint32_t leaf : leaves)
                for (const uint32_t instance : culling.hierarchy_.items(leaf))
                    if (!drawn || !(*drawn)[instance]) culling.instances_.push_back(instance);
            culling.scene_.collect(view.eye, std::span(culling.instances_).subspan(first), culling.list_);
            submit(culling.list_);
        }
        ViewCulling& culling;
        const CullView& view;
        const gpuscene::Submit& submit;
        const std::vector<bool>* drawn;
    };
    instances_.clear();
    if (hierarchy_.nodes().empty()) return;
    queries_.use(state);
    Renderer renderer(*this, view, submit, drawn);
    AlreadyDrawn already;
    if (drawn)
        already = [&](uint32_t leaf) {
            return std::ranges::all_of(hierarchy_.items(leaf), [&](uint32_t instance) { return bool((*drawn)[instance]); });
        };
    culler_.cull(view, state_, queries_, renderer, already);
}

}  // namespace dapple::visibility
