#include "scenegen/views/pick_views.h"

#include "scenegen/views/quick_render.h"

#include <algorithm>

namespace dapple::scenegen {
namespace {

constexpr double kLeastScore = 0.15;  ///< below it a picture holds hardly a caster and hardly a shadow
constexpr double kApart = 0.2;        ///< of the extent over which candidates stand; a fifth as much where that leaves too few

}  // namespace

std::vector<View> pickViews(const Scene& scene, const std::vector<View>& candidates, size_t count) {
    const QuickRender render(scene);
    std::vector<std::pair<double, const View*>> ranked;
    for (const View& view : candidates)
        if (const double score = render.look(view).score(); score > kLeastScore) ranked.emplace_back(score, &view);
    std::ranges::stable_sort(ranked, [](const auto& a, const auto& b) { return a.first > b.first; });

    base::DBox stands;
    for (const View& view : candidates) stands.extend(view.eye);
    const double extent = candidates.empty() ? 0 : std::max(stands.hi.x - stands.lo.x, stands.hi.y - stands.lo.y);
    std::vector<View> picked;
    for (const double apart : {kApart, 0.2 * kApart})
        for (const auto& scored : ranked) {
            const View& view = *scored.second;
            const auto isNear = [&](const View& other) { return glm::distance(other.eye, view.eye) < apart * extent; };
            if (picked.size() < count && std::ranges::none_of(picked, isNear)) picked.push_back(view);
        }
    return picked;
}

}  // namespace dapple::scenegen
