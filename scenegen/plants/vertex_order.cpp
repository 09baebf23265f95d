#include "scenegen/plants/vertex_order.h"

#include <algorithm>
#include <cmath>

// Tom Forsyth, "Linear-Speed Vertex Cache Optimisation" (2006), with his constants.
namespace dapple::scenegen {
namespace {

constexpr size_t kCacheSize = 16;

/// `place`: in the least-recently-used cache, kCacheSize = not in it.
double score(size_t place, size_t trianglesLeft) {
    if (trianglesLeft == 0) return -1;
    double s = 0;
    if (place < 3) {
        s = 0.75;  // the last triangle's vertices: equal, whichever of its corners came first
    } else if (place < kCacheSize) {
        const double fresh = 1 - double(place - 3) / double(kCacheSize - 3);
        s = fresh * std::sqrt(fresh);
    }
    return s + 2 / std::sqrt(double(trianglesLeft));
}

}  // namespace

std::vector<uint32_t> orderForVertexCache(std::vector<uint32_t>& indices, size_t vertices) {
    const size_t triangles = indices.size() / 3;
    std::vector<std::vector<uint32_t>> left(vertices);  // triangles round a vertex that are not yet emitted
    for (size_t i = 0; i < indices.size(); ++i) left[indices[i]].push_back(uint32_t(i / 3));

    std::vector<uint32_t> cache, ordered;
    std::vector<bool> emitted(triangles, false);
    const auto placeOf = [&](uint32_t v) { return size_t(std::find(cache.begin(), cache.end(), v) - cache.begin()); };
    const auto vertexScore = [&](uint32_t v) {
        const size_t place = placeOf(v);
        return score(place < cache.size() ? place : kCacheSize, left[v].size());
    };
    size_t firstLeft = 0;
    while (ordered.size() < indices.size()) {
        size_t best = triangles;
        double bestScore = -1;
        for (const uint32_t v : cache)
            for (const uint32_t t : left[v]) {
                double sum = 0;
                for (size_t k = 0; k < 3; ++k) sum += vertexScore(indices[3 * t + k]);
                if (sum > bestScore) bestScore = sum, best = t;
            }
        while (firstLeft < triangles && emitted[firstLeft]) ++firstLeft;
        if (best == triangles) best = firstLeft;
        emitted[best] = true;
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t v = indices[3 * best + k];
            ordered.push_back(v);
            std::erase(left[v], uint32_t(best));
            std::erase(cache, v);
            cache.insert(cache.begin(), v);
        }
        if (cache.size() > kCacheSize) cache.resize(kCacheSize);
    }

    std::vector<uint32_t> oldOf, newOf(vertices, ~0u);
    for (uint32_t& v : ordered) {
        if (newOf[v] == ~0u) {
            newOf[v] = uint32_t(oldOf.size());
            oldOf.push_back(v);
        }
        v = newOf[v];
    }
    indices = std::move(ordered);
    return oldOf;
}

}  // namespace dapple::scenegen
