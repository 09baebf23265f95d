#include "scenegen/city/region.h"

#include "base/detmath.h"

#include <algorithm>

namespace dapple::scenegen::city {

Line Region::edge(size_t i) const {
    const glm::dvec2 d = next(i) - corners[i];
    return {corners[i], d / std::sqrt(glm::dot(d, d))};
}

double Region::area() const {
    double twice = 0;
    for (size_t i = 0; i < size(); ++i) {
        const glm::dvec2 a = corners[i] - corners[0], b = next(i) - corners[0];
        twice += a.x * b.y - a.y * b.x;
    }
    return 0.5 * twice;
}

glm::dvec2 Region::centroid() const {
    glm::dvec2 sum(0);
    double twice = 0;
    for (size_t i = 0; i < size(); ++i) {
        const glm::dvec2 a = corners[i] - corners[0], b = next(i) - corners[0];
        const double cross = a.x * b.y - a.y * b.x;
        sum += (a + b) * cross;
        twice += cross;
    }
    return corners[0] + sum / (3 * twice);
}

bool Region::contains(const glm::dvec2& p, double margin) const {
    for (size_t i = 0; i < size(); ++i)
        if (!(edge(i).distance(p) >= margin)) return false;
    return !empty();
}

double Region::frontage() const {
    double sum = 0;
    for (size_t i = 0; i < size(); ++i)
        if (labels[i] >= 0) sum += length(i);
    return sum;
}

Region rectangle(const glm::dvec2& lo, const glm::dvec2& hi, int label) {
    return {{lo, {hi.x, lo.y}, hi, {lo.x, hi.y}}, std::vector<int>(4, label)};
}

Region clip(const Region& region, const Line& line, int label) {
    Region out;
    const size_t n = region.size();
    out.corners.reserve(n + 1);
    out.labels.reserve(n + 1);
    const auto add = [&](const glm::dvec2& p, int l) {
        // A corner on top of the last one ends an edge of no length: the new edge takes its place.
        if (!out.empty() && glm::distance(out.corners.back(), p) < 1e-3) out.labels.back() = l;
        else out.corners.push_back(p), out.labels.push_back(l);
    };
    double here = n > 0 ? line.distance(region.corners[0]) : 0;
    for (size_t i = 0; i < n; ++i) {
        const double there = line.distance(region.next(i));
        const bool in = here >= 0, nextIn = there >= 0;
        if (in) add(region.corners[i], region.labels[i]);
        if (in != nextIn) add(region.corners[i] + (region.next(i) - region.corners[i]) * (here / (here - there)), in ? label : region.labels[i]);
        here = there;
    }
    while (out.size() > 1 && glm::distance(out.corners.back(), out.corners.front()) < 1e-3) {
        out.corners.pop_back();
        out.labels.pop_back();
    }
    if (out.size() < 3 || out.area() < 1e-4) return {};
    return out;
}

Extent orientedBox(const Region& region) {
    Extent best{};
    double bestArea = 1e300;
    for (size_t i = 0; i < region.size(); ++i) {
        const Line e = region.edge(i);
        Extent x{e.direction, 1e300, -1e300, 1e300, -1e300};
        for (const glm::dvec2& p : region.corners) {
            const double u = glm::dot(p, e.direction), v = glm::dot(p, e.left());
            x.alongLo = std::min(x.alongLo, u), x.alongHi = std::max(x.alongHi, u);
            x.acrossLo = std::min(x.acrossLo, v), x.acrossHi = std::max(x.acrossHi, v);
        }
        if (x.length() * x.width() >= bestArea * (1 - 1e-9)) continue;
        bestArea = x.length() * x.width();
        best = x.length() >= x.width() ? x : Extent{e.left(), x.acrossLo, x.acrossHi, -x.alongHi, -x.alongLo};
    }
    return best;
}

double angleOf(const glm::dvec2& direction) {
    const double a = base::det::acos(direction.x);
    return direction.y < 0 ? -a : a;
}

}  // namespace dapple::scenegen::city
