#include "scenegen/city/rings.h"

namespace dapple::scenegen::city {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

const glm::dvec2& after(const Ring& r, size_t i) { return r[i + 1 < r.size() ? i + 1 : 0]; }

}  // namespace

double twiceArea(const Ring& ring) {
    double sum = 0;
    for (size_t i = 1; i + 1 < ring.size(); ++i) sum += cross(ring[0], ring[i], ring[i + 1]);
    return sum;
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
