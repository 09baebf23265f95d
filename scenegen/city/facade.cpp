#include "scenegen/city/facade.h"

namespace dapple::scenegen::city {
namespace {

/// Along the wall, outwards, up.
struct Frame {
    glm::dvec2 a, b, along, outward;

    Frame(const glm::dvec2& from, const glm::dvec2& to) : a(from), b(to) {
        along = (b - a) / std::sqrt(glm::dot(b - a, b - a));
        outward = {along.y, -along.x};
    }
    glm::dvec3 at(double x, double out, double z) const { return {a + along * x + outward * out, z}; }
    void box(Mesh& mesh, double x0, double x1, double out0, double out1, double z0, double z1) const {
        const glm::dvec3 low[] = {at(x0, out1, z0), at(x1, out1, z0), at(x1, out0, z0), at(x0, out0, z0)};
        const glm::dvec3 high[] = {at(x0, out1, z1), at(x1, out1, z1), at(x1, out0, z1), at(x0, out0, z1)};
        addLoft(mesh, low, high);
    }
};

/// Corner i of `count` cells between a and b: the ends are exact, so that walls meet.
glm::dvec2 corner(const glm::dvec2& a, const glm::dvec2& b, int i, int count) { return i == 0 ? a : i == count ? b : a + (b - a) * (double(i) / count); }

void addFittings(Parts& parts, const Frame& f, double x0, double x1, double z0, double z1, double depth, const Fittings& fittings) {
    // Panes are a little larger than the opening: their rims lie in the wall.
    f.box(parts.glass, x0 - 0.02, x1 + 0.02, -depth - 0.03, -depth + 0.04, z0 - 0.02, z1 + 0.02);
    const double middle = 0.5 * (x0 + x1), transom = z0 + 0.68 * (z1 - z0);
    if (fittings.cross) {
        f.box(parts.trim, middle - 0.04, middle + 0.04, -depth + 0.02, -depth + 0.09, z0 - 0.01, z1 + 0.01);
        f.box(parts.trim, x0 - 0.01, x1 + 0.01, -depth + 0.03, -depth + 0.08, transom - 0.035, transom + 0.035);
    }
    if (fittings.sill) f.box(parts.trim, x0 - 0.1, x1 + 0.1, -depth + 0.03, 0.12, z0 - 0.09, z0 + 0.015);
    if (fittings.hood) f.box(parts.trim, x0 - 0.18, x1 + 0.18, -0.05, 0.2, z1 + 0.12, z1 + 0.3);
}

}  // namespace

void addWall(Parts& parts, const glm::dvec2& a, const glm::dvec2& b, int columns, std::span<const Row> rows) {
    const Frame f(a, b);
    const glm::vec3 n(f.outward, 0), s(f.along, 0);
    Mesh& wall = parts.wall;
    for (const Row& row : rows)
        for (int i = 0; i < columns; ++i) {
            const glm::dvec2 p = corner(a, b, i, columns), q = corner(a, b, i + 1, columns);
            const glm::dvec3 outer[4] = {{p, row.floor}, {q, row.floor}, {q, row.ceiling}, {p, row.ceiling}};
            if (!row.opening.exists()) {
                addFace(wall, outer);
                continue;
            }
            const Opening& o = row.opening;
            const double x0 = glm::dot(p - a, f.along) + o.side, x1 = glm::dot(q - a, f.along) - o.side;
            const double z0 = row.floor + o.sill, z1 = row.ceiling - o.head;
            if (row.fittings.flush) {
                addFace(wall, outer);
                f.box(parts.glass, x0, x1, -0.02, 0.02, z0, z1);
                continue;
            }
            const glm::dvec3 rim[4] = {f.at(x0, 0, z0), f.at(x1, 0, z0), f.at(x1, 0, z1), f.at(x0, 0, z1)};
            const glm::dvec3 deep[4] = {f.at(x0, -o.depth, z0), f.at(x1, -o.depth, z0), f.at(x1, -o.depth, z1), f.at(x0, -o.depth, z1)};
            // The four trapezoids round the opening share their eight corners.
            const auto base = uint32_t(wall.positions.size());
            for (const auto& corners : {outer, rim})
                for (int k = 0; k < 4; ++k) wall.positions.emplace_back(corners[k]), wall.normals.push_back(n);
            for (uint32_t k = 0; k < 4; ++k) {
                const uint32_t l = (k + 1) % 4;
                for (const uint32_t v : {k, l, l + 4, k, l + 4, k + 4}) wall.indices.push_back(base + v);
            }
            for (int k = 0; k < 4; ++k) addFace(wall, {rim[k], rim[(k + 1) % 4], deep[(k + 1) % 4], deep[k]});
            addFace(wall, deep);
            addFittings(parts, f, x0, x1, z0, z1, o.depth, row.fittings);
        }
}

void addLids(Mesh& mesh, std::span<const glm::dvec2> outline, std::span<const int> columns, double floor, double ceiling) {
    std::vector<glm::dvec2> rim;
    glm::dvec2 centre(0);
    for (size_t i = 0; i < outline.size(); ++i) {
        centre += outline[i] / double(outline.size());
        for (int k = 0; k < columns[i]; ++k) rim.push_back(corner(outline[i], outline[(i + 1) % outline.size()], k, columns[i]));
    }
    // Fans about the centre: the rim's corners lie in line, so that a fan from one of them would have flat triangles.
    for (const bool top : {false, true}) {
        const double z = top ? ceiling : floor;
        const glm::vec3 n(0, 0, top ? 1 : -1);
        const auto base = uint32_t(mesh.positions.size());
        mesh.positions.emplace_back(centre.x, centre.y, z);
        for (const glm::dvec2& p : rim) mesh.positions.emplace_back(p.x, p.y, z);
        mesh.normals.insert(mesh.normals.end(), rim.size() + 1, n);
        const auto count = uint32_t(rim.size());
        for (uint32_t k = 0; k < count; ++k) {
            const uint32_t here = base + 1 + k, next = base + 1 + (k + 1) % count;
            for (const uint32_t v : {base, top ? here : next, top ? next : here}) mesh.indices.push_back(v);
        }
    }
}

}  // namespace dapple::scenegen::city
