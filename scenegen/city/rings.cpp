#include "scenegen/city/rings.h"

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

}  // namespace dapple::scenegen::city
