#include "scenegen/plants/vertex_order.h"

#include <algorithm>
#include <array>
#include <deque>

namespace dapple::scenegen {
namespace {
constexpr size_t kCacheSize = 16;
}

std::vector<uint32_t> orderForVertexCache(std::vector<uint32_t>& indices, size_t vertices) {
    const size_t triangles = indices.size() / 3;
    std::vector<std::vector<uint32_t>> around(vertices);
    for (size_t i = 0; i < indices.size(); ++i) around[indices[i]].push_back(uint32_t(i / 3));

    std::vector<bool> emitted(triangles, false);
    std::deque<uint32_t> cache;
    const auto cached = [&](uint32_t v) { return std::find(cache.begin(), cache.end(), v) != cache.end(); };
    std::vector<uint32_t> ordered;
    size_t firstLeft = 0;
    while (ordered.size() < indices.size()) {
        size_t best = triangles;
        int fewest = 3;
        for (const uint32_t v : cache)
            for (const uint32_t t : around[v]) {
                if (emitted[t]) continue;
                int misses = 0;
                for (size_t k = 0; k < 3; ++k) misses += !cached(indices[3 * t + k]);
                if (misses < fewest) fewest = misses, best = t;
            }
        while (firstLeft < triangles && emitted[firstLeft]) ++firstLeft;
        if (best == triangles) best = firstLeft;
        emitted[best] = true;
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t v = indices[3 * best + k];
            ordered.push_back(v);
            if (cached(v)) continue;
            cache.push_back(v);
            if (cache.size() > kCacheSize) cache.pop_front();
        }
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
