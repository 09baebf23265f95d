#include "scenegen/city/triangulate.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// Whether the closed segments ab and cd have a point in common.
bool meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const auto sign = [](double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
    const int s[4] = {sign(cross(a, b, c)), sign(cross(a, b, d)), sign(cross(c, d, a)), sign(cross(c, d, b))};
    if (s[0] * s[1] < 0 && s[2] * s[3] < 0) return true;
    const auto on = [](const glm::dvec2& p, const glm::dvec2& q, const glm::dvec2& r) {
        return r.x >= std::min(p.x, q.x) && r.x <= std::max(p.x, q.x) && r.y >= std::min(p.y, q.y) && r.y <= std::max(p.y, q.y);
    };
    return (s[0] == 0 && on(a, b, c)) || (s[1] == 0 && on(a, b, d)) || (s[2] == 0 && on(c, d, a)) || (s[3] == 0 && on(c, d, b));
}

const glm::dvec2& after(const Ring& r, size_t i) { return r[i + 1 < r.size() ? i + 1 : 0]; }

}  // namespace

double twiceArea(const Ring& ring) {
    double sum = 0;
    for (size_t i = 1; i + 1 < ring.size(); ++i) sum += cross(ring[0], ring[i], ring[i + 1]);
    return sum;
}

bool isSimple(const Ring& ring) {
    for (size_t i = 0; i < ring.size(); ++i)
        for (size_t j = i + 1; j < ring.size(); ++j) {
            if (j == i + 1 || (i == 0 && j + 1 == ring.size())) {
                // Neighbours may not fold back on each other.
                const size_t a = j == i + 1 ? i : j, corner = a + 1 < ring.size() ? a + 1 : 0;
                const glm::dvec2 in = ring[a] - ring[corner], out = after(ring, corner) - ring[corner];
                if (cross({0, 0}, in, out) == 0 && glm::dot(in, out) > 0) return false;
            } else if (meet(ring[i], after(ring, i), ring[j], after(ring, j))) {
                return false;
            }
        }
    return ring.size() >= 3;
}

bool areApart(const Ring& a, const Ring& b) {
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t j = 0; j < b.size(); ++j)
            if (meet(a[i], after(a, i), b[j], after(b, j))) return false;
    return true;
}

bool contains(const Ring& ring, const glm::dvec2& p) {
    bool in = false;
    for (size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 a = ring[i], b = after(ring, i);
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) in = !in;
    }
    return in;
}

std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Ring>& rings) {
    struct Corner {
        glm::dvec2 p;
        uint32_t index;
    };
    std::vector<std::vector<Corner>> loops;
    uint32_t count = 0;
    for (const Ring& ring : rings) {
        loops.emplace_back();
        for (const glm::dvec2& p : ring) loops.back().push_back({p, count++});
    }
    std::vector<Corner> loop = loops[0];
    // The hole with the rightmost corner first: nothing but the outer ring and holes joined already lies to its right.
    std::vector<size_t> rightmost(loops.size());
    std::vector<size_t> order;
    for (size_t h = 1; h < loops.size(); ++h) {
        for (size_t k = 0; k < loops[h].size(); ++k)
            if (loops[h][k].p.x > loops[h][rightmost[h]].p.x) rightmost[h] = k;
        order.push_back(h);
    }
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return loops[a][rightmost[a]].p.x > loops[b][rightmost[b]].p.x; });
    for (const size_t h : order) {
        const std::vector<Corner>& hole = loops[h];
        const size_t from = rightmost[h];
        const glm::dvec2 m = hole[from].p;
        // The nearest corner of the loop that m sees.
        size_t best = loop.size();
        for (size_t k = 0; k < loop.size(); ++k) {
            if (best < loop.size() && glm::distance(loop[k].p, m) >= glm::distance(loop[best].p, m)) continue;
            // Within the corner's angle: else the bridge would start outside.
            const glm::dvec2 before = loop[(k + loop.size() - 1) % loop.size()].p, next = loop[(k + 1) % loop.size()].p;
            const bool left = cross(loop[k].p, next, m) > 0, right = cross(before, loop[k].p, m) > 0, convex = cross(before, loop[k].p, next) > 0;
            if (convex ? !(left && right) : !(left || right)) continue;
            bool seen = true;
            const auto hides = [&](const glm::dvec2& a, const glm::dvec2& b) {
                const bool touches = a == loop[k].p || b == loop[k].p || a == m || b == m;
                return !touches && meet(loop[k].p, m, a, b);
            };
            for (size_t i = 0; i < loop.size() && seen; ++i) seen = !hides(loop[i].p, loop[(i + 1) % loop.size()].p);
            for (size_t i = 0; i < hole.size() && seen; ++i) seen = !hides(hole[i].p, hole[(i + 1) % hole.size()].p);
            if (seen) best = k;
        }
        if (best == loop.size()) return {};
        std::vector<Corner> bridge{loop[best]};
        for (size_t k = 0; k <= hole.size(); ++k) bridge.push_back(hole[(from + k) % hole.size()]);
        loop.insert(loop.begin() + std::ptrdiff_t(best), bridge.begin(), bridge.end());
    }

    std::vector<std::array<uint32_t, 3>> triangles;
    while (loop.size() >= 3) {
        // The ear whose height over its longest side is greatest relative to that side.
        const size_t n = loop.size();
        size_t ear = n;
        double fattest = 1e-9;
        for (size_t k = 0; k < n; ++k) {
            const glm::dvec2 a = loop[(k + n - 1) % n].p, b = loop[k].p, c = loop[(k + 1) % n].p;
            const double area = cross(a, b, c), longest = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
            if (area <= fattest * longest) continue;
            const auto blocks = [&](const Corner& q) {
                return q.p != a && q.p != b && q.p != c && cross(a, b, q.p) >= 0 && cross(b, c, q.p) >= 0 && cross(c, a, q.p) >= 0;
            };
            if (std::any_of(loop.begin(), loop.end(), blocks)) continue;
            ear = k, fattest = area / longest;
        }
        if (ear == n) return {};
        triangles.push_back({loop[(ear + n - 1) % n].index, loop[ear].index, loop[(ear + 1) % n].index});
        loop.erase(loop.begin() + std::ptrdiff_t(ear));
    }
    return triangles;
}

}  // namespace dapple::scenegen::city
