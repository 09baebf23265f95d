#include "truth/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

/// Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8 (2012):
/// squared distance is separable; along each row it is the lower envelope of one parabola per column
/// (algorithm 1). All sums are integers below 2^53, and crossings lie at least 1/(2 · width) away from
/// an integer unless they fall on one, where both parabolas agree: the result is exact.
namespace dapple::truth {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Squared distance along the column to the nearest set pixel.
void transformColumn(std::span<const uint8_t> mask, size_t x, size_t width, size_t height, std::vector<double>& squared) {
    double distance = kInfinity;
    for (size_t y = 0; y < height; ++y) {
        distance = mask[y * width + x] ? 0 : distance + 1;
        squared[y * width + x] = distance * distance;
    }
    distance = kInfinity;
    for (size_t y = height; y-- > 0;) {
        distance = mask[y * width + x] ? 0 : distance + 1;
        squared[y * width + x] = std::min(squared[y * width + x], distance * distance);
    }
}

struct Parabola {
    double vertex, height, from;  ///< lowest from abscissa `from` to the next parabola's
};

void transformRow(std::span<double> row, std::vector<Parabola>& envelope) {
    envelope.clear();
    for (size_t i = 0; i < row.size(); ++i) {
        if (row[i] == kInfinity) continue;
        const auto q = double(i);
        double from = -kInfinity;
        while (!envelope.empty()) {
            const Parabola& last = envelope.back();
            from = ((row[i] + q * q) - (last.height + last.vertex * last.vertex)) / (2 * (q - last.vertex));
            if (from > last.from) break;
            envelope.pop_back();
            from = -kInfinity;
        }
        envelope.push_back({q, row[i], from});
    }
    if (envelope.empty()) return;
    size_t k = 0;
    for (size_t i = 0; i < row.size(); ++i) {
        const auto q = double(i);
        while (k + 1 < envelope.size() && envelope[k + 1].from < q) ++k;
        row[i] = (q - envelope[k].vertex) * (q - envelope[k].vertex) + envelope[k].height;
    }
}

}  // namespace

std::vector<float> distanceTransform(std::span<const uint8_t> mask, int width, int height) {
    const auto w = size_t(width), h = size_t(height);
    assert(mask.size() == w * h);
    std::vector<double> squared(w * h);
    for (size_t x = 0; x < w; ++x) transformColumn(mask, x, w, h, squared);
    std::vector<Parabola> envelope;
    std::vector<float> distance(w * h);
    for (size_t y = 0; y < h; ++y) transformRow(std::span(squared).subspan(y * w, w), envelope);
    for (size_t i = 0; i < distance.size(); ++i) distance[i] = float(std::sqrt(squared[i]));
    return distance;
}

}  // namespace dapple::truth
