#include "scenegen/city/views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dapple::scenegen::city {

void addViews(Scene& scene, const Plan& plan, int count, double fovY) {
    const Extent extent = orientedBox(plan.ground);
    // Boulevards and narrow streets in turn, long ones with houses on both sides first.
    std::vector<Street> streets[2];
    double widest = 0;
    for (const Street& s : plan.streets) widest = std::max(widest, s.width);
    for (const Street& s : plan.streets) streets[s.width <= 0.6 * widest].push_back(s);
    for (std::vector<Street>& some : streets)
        std::stable_sort(some.begin(), some.end(), [&](const Street& a, const Street& b) {
            const auto rank = [&](const Street& s) { return std::pair(!plan.ground.contains(0.5 * (s.a + s.b), 40), -glm::distance(s.a, s.b)); };
            return rank(a) < rank(b);
        });
    for (int i = 0; i < count; ++i) {
        const std::vector<Street>& some = streets[i % 2 && !streets[1].empty()];
        Street s = some[size_t(i / 2) % some.size()];
        if (i % 2) std::swap(s.a, s.b);
        const double length = glm::distance(s.a, s.b);
        const glm::dvec2 u = (s.b - s.a) / length;
        // A pedestrian's eye in the middle, between the lanes, looking slightly to the left and up.
        const glm::dvec2 eye = s.a + u * (length * (0.22 + 0.11 * double(i / 2 % 4)));
        const glm::dvec3 ahead(u + 0.12 * glm::dvec2(-u.y, u.x), 0.15);
        View view{.name = fmt::format("walk{}", i), .eye = {eye, 1.7}, .forward = ahead / std::sqrt(glm::dot(ahead, ahead)), .fovY = fovY};
        view.near = 0.3, view.far = std::max(400.0, extent.length());
        scene.views.push_back(view);
    }
    const double reach = 0.5 * extent.length();
    View above{.name = "above", .eye = glm::dvec3(-0.62, -0.7, 0.42) * reach, .fovY = fovY};
    above.forward = glm::normalize(glm::dvec3(-0.1 * reach, -0.15 * reach, 0) - above.eye);
    above.near = 1, above.far = 5 * reach + 300;
    scene.views.push_back(above);
}

}  // namespace dapple::scenegen::city
