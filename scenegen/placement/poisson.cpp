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

Disks poissonDisks(std::span<const double> radii, double half, uint64_t seed, Crowding crowding,
                   const std::function<bool(size_t, const glm::dvec2&)>& allowed) {
    Disks disks;
    if (radii.empty()) return disks;
    std::vector<uint32_t> order(radii.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return radii[a] > radii[b]; });

    // A cell is as wide as the farthest conflict, so that nine cells hold all of them. Each is a linked list.
    const double reach = 2 * radii[order[0]];
    const int cells = reach > 0 ? int(std::clamp(2 * half / reach, 1.0, 4096.0)) : 4096;
    constexpr uint32_t kEnd = ~0u;
    struct Placed {
        glm::dvec2 point;
        double radius;
        uint32_t next;
    };
    std::vector<uint32_t> heads(size_t(cells) * size_t(cells), kEnd), who;
    std::vector<Placed> placed;
    placed.reserve(radii.size());
    who.reserve(radii.size());
    const auto cellOf = [&](double v) { return std::clamp(int((v + half) / (2 * half) * cells), 0, cells - 1); };
    double factor = 1;
    const auto isFree = [&](const glm::dvec2& p, int cx, int cy, double radius) {
        for (int y = std::max(0, cy - 1); y <= std::min(cells - 1, cy + 1); ++y)
            for (int x = std::max(0, cx - 1); x <= std::min(cells - 1, cx + 1); ++x)
                for (uint32_t j = heads[size_t(y) * size_t(cells) + size_t(x)]; j != kEnd; j = placed[j].next) {
                    const double apart = factor * (radius + placed[j].radius);
                    if (glm::dot(placed[j].point - p, placed[j].point - p) < apart * apart) return false;
                }
        return true;
    };
    const int darts = crowding == Crowding::thin ? 1 : kDarts;
    for (const uint32_t i : order) {
        base::Random random(seed, i, 0x706f6973736f6e);
        for (int dart = 0;; ++dart) {
            if (dart == darts) {
                if (crowding == Crowding::thin) break;
                dart = 0;
                factor *= 0.9;
                if (factor < 0.2)
                    throw base::UsageError(fmt::format("{} trees do not fit on a ground of {} m: fewer trees or a larger ground", radii.size(), 2 * half));
            }
            const glm::dvec2 p{half * (2.0 * random.next() - 1), half * (2.0 * random.next() - 1)};  // braces: drawn in this order
            const int cx = cellOf(p.x), cy = cellOf(p.y);
            if (!allowed(i, p) || !isFree(p, cx, cy, radii[i])) continue;
            uint32_t& head = heads[size_t(cy) * size_t(cells) + size_t(cx)];
            placed.push_back({p, radii[i], head});
            head = uint32_t(placed.size() - 1);
            who.push_back(i);
            break;
        }
    }
    std::vector<uint32_t> byIndex(who.size());
    std::iota(byIndex.begin(), byIndex.end(), 0u);
    std::sort(byIndex.begin(), byIndex.end(), [&](uint32_t a, uint32_t b) { return who[a] < who[b]; });
    for (const uint32_t k : byIndex) {
        disks.kept.push_back(who[k]);
        disks.points.push_back(placed[k].point);
    }
    return disks;
}

}  // namespace dapple::scenegen
