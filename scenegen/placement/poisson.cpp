#include "scenegen/placement/poisson.h"

#include "base/error.h"
#include "base/random.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dapple::scenegen {
namespace {
constexpr int kDarts = 30;  // Bridson 2007
}

std::vector<glm::dvec2> poissonDisks(std::span<const double> radii, double half, uint64_t seed,
                                     const std::function<bool(const glm::dvec2&)>& allowed) {
    std::vector<glm::dvec2> points(radii.size());
    if (radii.empty()) return points;
    std::vector<size_t> order(radii.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return radii[a] > radii[b]; });

    // A cell is as wide as the farthest conflict, so that nine cells hold all of them.
    const double reach = 2 * radii[order[0]];
    const int cells = std::clamp(int(2 * half / reach), 1, 4096);
    std::vector<std::vector<size_t>> grid(size_t(cells) * size_t(cells));
    const auto cellOf = [&](double v) { return std::clamp(int((v + half) / (2 * half) * cells), 0, cells - 1); };
    double factor = 1;
    for (const size_t i : order) {
        base::Random random(seed, i, 0x706f6973736f6e);
        for (int dart = 0;; ++dart) {
            if (dart == kDarts) {
                dart = 0;
                factor *= 0.9;
                if (factor < 0.2)
                    throw base::UsageError(fmt::format("{} trees do not fit on a ground of {} m: fewer trees or a larger ground.size", radii.size(), 2 * half));
            }
            const glm::dvec2 p{half * (2.0 * random.next() - 1), half * (2.0 * random.next() - 1)};  // braces: drawn in this order
            if (!allowed(p)) continue;
            const int cx = cellOf(p.x), cy = cellOf(p.y);
            bool free = true;
            for (int y = std::max(0, cy - 1); free && y <= std::min(cells - 1, cy + 1); ++y)
                for (int x = std::max(0, cx - 1); free && x <= std::min(cells - 1, cx + 1); ++x)
                    for (const size_t j : grid[size_t(y) * size_t(cells) + size_t(x)]) {
                        const double apart = factor * (radii[i] + radii[j]);
                        if (glm::dot(points[j] - p, points[j] - p) < apart * apart) free = false;
                    }
            if (!free) continue;
            points[i] = p;
            grid[size_t(cy) * size_t(cells) + size_t(cx)].push_back(i);
            break;
        }
    }
    return points;
}

}  // namespace dapple::scenegen
