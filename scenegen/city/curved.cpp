#include "scenegen/city/curved.h"

#include "base/detmath.h"
#include "scenegen/city/solid.h"

#include <algorithm>

namespace dapple::scenegen::city {
namespace {

glm::dvec2 unit(const glm::dvec2& v) { return v / std::sqrt(glm::dot(v, v)); }
glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

/// A quadrangle, counter-clockwise from outside, with a normal at each corner.
void addQuad(Mesh& mesh, const glm::dvec3 (&corners)[4], const glm::dvec3 (&normals)[4]) {
    const auto base = uint32_t(mesh.positions.size());
    for (int k = 0; k < 4; ++k) mesh.positions.emplace_back(corners[k]), mesh.normals.emplace_back(normals[k]);
    for (const uint32_t v : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + v);
}

/// (cos, sin) on the upper half circle from the left to the right, both ends exact.
std::vector<glm::dvec2> halfCircle(int segments) {
    std::vector<glm::dvec2> points;
    for (int k = 0; k <= segments; ++k) {
        const base::det::SinCos t = base::det::sinCos(base::det::kPi * (1 - double(k) / segments));
        points.emplace_back(t.cos, t.sin);
    }
    points.front() = {-1, 0}, points.back() = {1, 0};
    return points;
}

/// The face of a half cylinder about (0, z0) between y0 and y1; seen from within, or with `outwards` from without.
void addVault(Mesh& mesh, std::span<const glm::dvec2> circle, double z0, double radius, double y0, double y1, bool outwards) {
    for (size_t k = 0; k + 1 < circle.size(); ++k) {
        const glm::dvec2 a = circle[outwards ? k + 1 : k], b = circle[outwards ? k : k + 1];
        const glm::dvec3 p{radius * a.x, 0, z0 + radius * a.y}, q{radius * b.x, 0, z0 + radius * b.y}, front{0, y0, 0}, back{0, y1, 0};
        const double sign = outwards ? 1 : -1;
        const glm::dvec3 n = sign * glm::dvec3(a.x, 0, a.y), m = sign * glm::dvec3(b.x, 0, b.y);
        addQuad(mesh, {p + front, p + back, q + back, q + front}, {n, n, m, m});
    }
}

}  // namespace

void addLathe(Mesh& mesh, const glm::dvec3& foot, std::span<const glm::dvec2> profile, int sides) {
    std::vector<glm::dvec2> turn;
    for (int k = 0; k < sides; ++k) {
        const base::det::SinCos t = base::det::sinCos(2 * base::det::kPi * (k + 0.5) / sides);
        turn.emplace_back(t.cos, t.sin);
    }
    const auto at = [&](size_t i, size_t k) { return foot + glm::dvec3(profile[i].x * turn[k], profile[i].y); };
    std::vector<glm::dvec2> normals;  // of the bands: (outwards, upwards)
    for (size_t i = 0; i + 1 < profile.size(); ++i) normals.push_back(unit(glm::dvec2(profile[i + 1].y - profile[i].y, profile[i].x - profile[i + 1].x)));
    const auto smooth = [&](size_t band, size_t point) {
        const size_t other = point == band ? band - 1 : band + 1;
        return other < normals.size() && glm::dot(normals[band], normals[other]) > 0.8 ? unit(normals[band] + normals[other]) : normals[band];
    };
    for (size_t i = 0; i < normals.size(); ++i) {
        const glm::dvec2 low = smooth(i, i), high = smooth(i, i + 1);
        for (size_t j = turn.size() - 1, k = 0; k < turn.size(); j = k++)
            addQuad(mesh, {at(i, j), at(i, k), at(i + 1, k), at(i + 1, j)},
                    {{low.x * turn[j], low.y}, {low.x * turn[k], low.y}, {high.x * turn[k], high.y}, {high.x * turn[j], high.y}});
    }
    std::vector<glm::dvec3> bottom, top;
    for (size_t k = 0; k < turn.size(); ++k) bottom.push_back(at(0, turn.size() - 1 - k)), top.push_back(at(profile.size() - 1, k));
    addFace(mesh, bottom);
    addFace(mesh, top);
}

void addArchPanel(Mesh& mesh, const ArchPanel& panel, int segments) {
    const std::vector<glm::dvec2> circle = halfCircle(segments);
    std::vector<glm::dvec2> lower{{-0.5 * panel.width, panel.springing}};  // x and the height at which the wall begins there
    for (const glm::dvec2& c : circle) lower.emplace_back(panel.radius * c.x, panel.springing + panel.radius * c.y);
    lower.emplace_back(0.5 * panel.width, panel.springing);
    const double front = -0.5 * panel.thickness, back = 0.5 * panel.thickness, top = panel.top;
    for (size_t i = 0; i + 1 < lower.size(); ++i) {
        const glm::dvec2 p = lower[i], q = lower[i + 1];
        addFace(mesh, {{p.x, front, p.y}, {q.x, front, q.y}, {q.x, front, top}, {p.x, front, top}});
        addFace(mesh, {{p.x, back, p.y}, {p.x, back, top}, {q.x, back, top}, {q.x, back, q.y}});
        addFace(mesh, {{p.x, front, top}, {q.x, front, top}, {q.x, back, top}, {p.x, back, top}});
        if (i == 0 || i + 2 == lower.size()) addFace(mesh, {{p.x, front, p.y}, {p.x, back, p.y}, {q.x, back, q.y}, {q.x, front, q.y}});
    }
    const glm::dvec2 l = lower.front(), r = lower.back();
    addFace(mesh, {{l.x, back, l.y}, {l.x, front, l.y}, {l.x, front, top}, {l.x, back, top}});
    addFace(mesh, {{r.x, front, r.y}, {r.x, back, r.y}, {r.x, back, top}, {r.x, front, top}});
    addVault(mesh, circle, panel.springing, panel.radius, front, back, false);
}

void addArchRing(Mesh& mesh, double springing, double inner, double outer, double front, double back, int segments) {
    const std::vector<glm::dvec2> circle = halfCircle(segments);
    const auto at = [&](double radius, const glm::dvec2& c, double y) { return glm::dvec3(radius * c.x, y, springing + radius * c.y); };
    for (size_t k = 0; k + 1 < circle.size(); ++k) {
        const glm::dvec2 c = circle[k], d = circle[k + 1];
        addFace(mesh, {at(inner, c, front), at(inner, d, front), at(outer, d, front), at(outer, c, front)});
        addFace(mesh, {at(inner, c, back), at(outer, c, back), at(outer, d, back), at(inner, d, back)});
    }
    addVault(mesh, circle, springing, inner, front, back, false);
    addVault(mesh, circle, springing, outer, front, back, true);
    for (const auto& [a, b] : {std::pair(-outer, -inner), std::pair(inner, outer)}) addFace(mesh, {{a, front, springing}, {a, back, springing}, {b, back, springing}, {b, front, springing}});
}

void addSheet(Mesh& mesh, int columns, int rows, double thickness, const std::function<glm::dvec3(double u, double v)>& surface) {
    const auto at = [&](int i, int j) { return surface(double(i) / columns, double(j) / rows); };
    const auto number = [&](int i, int j) { return size_t(j) * size_t(columns + 1) + size_t(i); };
    std::vector<glm::dvec3> front, back;
    const auto base = uint32_t(mesh.positions.size()), count = uint32_t((columns + 1) * (rows + 1));
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const glm::dvec3 du = at(std::min(i + 1, columns), j) - at(std::max(i - 1, 0), j), dv = at(i, std::min(j + 1, rows)) - at(i, std::max(j - 1, 0));
            const glm::dvec3 n = unit(glm::cross(du, dv)), p = at(i, j);
            front.push_back(p + 0.5 * thickness * n), back.push_back(p - 0.5 * thickness * n);
            mesh.positions.emplace_back(front.back()), mesh.normals.emplace_back(n);
        }
    for (uint32_t k = 0; k < count; ++k) mesh.positions.emplace_back(back[k]), mesh.normals.push_back(-mesh.normals[base + k]);
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = base + uint32_t(number(i, j)), b = a + 1, c = b + uint32_t(columns + 1), d = c - 1;
            for (const uint32_t v : {a, b, c, a, c, d, a + count, c + count, b + count, a + count, d + count, c + count}) mesh.indices.push_back(v);
        }
    std::vector<size_t> rim;
    for (int i = 0; i < columns; ++i) rim.push_back(number(i, 0));
    for (int j = 0; j < rows; ++j) rim.push_back(number(columns, j));
    for (int i = columns; i > 0; --i) rim.push_back(number(i, rows));
    for (int j = rows; j > 0; --j) rim.push_back(number(0, j));
    for (size_t k = 0; k < rim.size(); ++k) {
        const size_t a = rim[k], b = rim[(k + 1) % rim.size()];
        addFace(mesh, {front[b], front[a], back[a], back[b]});
    }
}

}  // namespace dapple::scenegen::city
