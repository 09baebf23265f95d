#include "scenegen/city/triangulate.h"

#include "base/hash.h"
#include "scenegen/city/delaunay.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dapple::scenegen::city {
namespace {

constexpr double kTolerance = 1e-6;  // of the size: float coordinates of a bridge's two sides differ by less

bool isBefore(const glm::dvec2& a, const glm::dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

/// A corner of a ring without repeats, and its neighbours there.
struct Corner {
    uint32_t index;  // through all rings as given
    uint32_t point, before, after;
};

/// Whether triangle v, a, b lies in the angle at v that runs counter-clockwise from `after` to `before`.
bool fills(const glm::dvec2& before, const glm::dvec2& v, const glm::dvec2& after, const glm::dvec2& a,
           const glm::dvec2& b) {
    const auto isTowards = [&](const glm::dvec2& p, const glm::dvec2& q) {
        return turn(v, p, q) == 0 && glm::dot(p - v, q - v) > 0;
    };
    if (isTowards(after, before)) return true;  // the end of a bridge: all around
    const auto isBetween = [&](const glm::dvec2& p) {
        const bool left = turn(v, after, p) > 0, right = turn(before, v, p) > 0;
        return turn(before, v, after) > 0 ? left && right : left || right;
    };
    const bool fromA = isTowards(after, a) || (!isTowards(before, a) && isBetween(a));
    return fromA && (isTowards(before, b) || (!isTowards(after, b) && isBetween(b)));
}

/// `points` in the order of isBefore.
std::vector<Corner> cornersOf(const std::vector<Ring>& rings, const std::vector<glm::dvec2>& points) {
    std::vector<Corner> corners;
    uint32_t index = 0;
    for (const Ring& ring : rings) {
        const size_t first = corners.size();
        for (const glm::dvec2& p : ring) {
            const auto point = uint32_t(std::lower_bound(points.begin(), points.end(), p, isBefore) - points.begin());
            if (corners.size() == first || corners.back().point != point) corners.push_back({index, point, 0, 0});
            ++index;
        }
        while (corners.size() > first + 1 && corners.back().point == corners[first].point) corners.pop_back();
        const size_t n = corners.size() - first;
        for (size_t i = 0; i < n; ++i) {
            corners[first + i].after = corners[first + (i + 1) % n].point;
            corners[first + i].before = corners[first + (i + n - 1) % n].point;
        }
    }
    return corners;
}

}  // namespace

std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Ring>& rings) {
    std::vector<glm::dvec2> points;
    for (const Ring& ring : rings) points.insert(points.end(), ring.begin(), ring.end());
    const auto isFinite = [](const glm::dvec2& p) { return std::abs(p.x) < 1e75 && std::abs(p.y) < 1e75; };
    if (points.size() < 3 || !std::all_of(points.begin(), points.end(), isFinite)) return {};

    // Corners at one place are one point.
    std::sort(points.begin(), points.end(), isBefore);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3) return {};
    std::vector<Corner> corners = cornersOf(rings, points);

    glm::dvec2 lo(points[0]), hi(points[0]);
    for (const glm::dvec2& p : points) lo = glm::min(lo, p), hi = glm::max(hi, p);
    const double tolerance = kTolerance * std::max(hi.x - lo.x, hi.y - lo.y);
    Delaunay mesh(points);
    // In random order: walls in turn along a comb would each cross all edges that the rest have yet to split.
    std::vector<uint32_t> order(corners.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [](uint32_t a, uint32_t b) { return base::mix64(a) < base::mix64(b); });
    for (const uint32_t i : order)
        if (!mesh.addWall(corners[i].point, corners[i].after, tolerance)) return {};
    mesh.refine();
    const std::vector<uint32_t> inside = mesh.insideOddWalls();

    // Corners by point.
    const auto byPoint = [](const Corner& a, const Corner& b) { return a.point < b.point; };
    std::stable_sort(corners.begin(), corners.end(), byPoint);
    std::vector<uint32_t> first(points.size() + 1);
    for (const Corner& c : corners) ++first[c.point + 1];
    for (size_t i = 0; i < points.size(); ++i) first[i + 1] += first[i];
    std::vector<std::array<uint32_t, 3>> triangles(inside.size() / 3);
    for (size_t t = 0; t < triangles.size(); ++t)
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t v = inside[3 * t + k];
            const glm::dvec2 &a = points[inside[3 * t + (k + 1) % 3]], &b = points[inside[3 * t + (k + 2) % 3]];
            const auto begin = corners.begin() + first[v], end = corners.begin() + first[v + 1];
            const auto isIts = [&](const Corner& c) {
                return fills(points[c.before], points[v], points[c.after], a, b);
            };
            const auto found = end - begin > 1 ? std::find_if(begin, end, isIts) : begin;
            triangles[t][k] = (found == end ? begin : found)->index;
        }
    return triangles;
}

}  // namespace dapple::scenegen::city
