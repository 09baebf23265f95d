#include "scenegen/import/polygons.h"

#include "scenegen/city/triangulate.h"

#include <cmath>

namespace dapple::scenegen {
namespace {

/// Newell's: twice the area long, and right for concave and not quite flat polygons.
glm::dvec3 normalOf(std::span<const glm::dvec3> corners) {
    glm::dvec3 n(0);
    for (size_t i = 0; i < corners.size(); ++i)
        n += glm::cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    return n;
}

/// Along the axis that the normal is nearest to: coordinates stay exact, and what is collinear stays so.
city::Ring seenAlong(const glm::dvec3& normal, std::span<const glm::dvec3> corners) {
    const glm::dvec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    const int u = (axis + (normal[axis] > 0 ? 1 : 2)) % 3, v = 3 - axis - u;
    city::Ring points;
    for (const glm::dvec3& p : corners) points.emplace_back(p[u] - corners[0][u], p[v] - corners[0][v]);
    return points;
}

double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Whether the triangles cover the polygon once. Its corners count as on an edge when they are within a millionth of
/// its size.
bool covers(const std::vector<std::array<uint32_t, 3>>& triangles, const city::Ring& ring) {
    double sum = 0;
    for (const auto& t : triangles) sum += cross(ring[t[0]], ring[t[1]], ring[t[2]]);
    return std::abs(sum - city::twiceArea(ring)) <= 1e-5 * sum;
}

}  // namespace

bool cutPolygon(std::span<const glm::dvec3> corners, std::vector<std::array<uint32_t, 3>>& triangles) {
    const auto fan = [&](uint32_t first) {
        const auto n = uint32_t(corners.size());
        for (uint32_t i = 1; i + 1 < n; ++i) triangles.push_back({first, (first + i) % n, (first + i + 1) % n});
    };
    const glm::dvec3 normal = normalOf(corners);
    if (corners.size() < 4 || !(glm::length(normal) > 0)) return fan(0), true;
    const city::Ring points = seenAlong(normal, corners);
    if (corners.size() == 4) {
        // A quad is cut at its reflex corner, else between the first and the third.
        for (const uint32_t first : {0u, 1u})
            if (cross(points[first], points[first + 1], points[first + 2]) >= 0 &&
                cross(points[first], points[first + 2], points[(first + 3) % 4]) >= 0)
                return fan(first), true;
        return fan(0), false;
    }
    const auto cut = city::triangulate({points});
    if (cut.empty() || !covers(cut, points)) return fan(0), false;
    triangles.insert(triangles.end(), cut.begin(), cut.end());
    return true;
}

}  // namespace dapple::scenegen
