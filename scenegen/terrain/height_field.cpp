#include "scenegen/terrain/height_field.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {

double HeightField::height(double px, double py) const {
    const double u = std::clamp(px / spacing + 0.5 * (columns - 1), 0.0, double(columns - 1));
    const double v = std::clamp(py / spacing + 0.5 * (rows - 1), 0.0, double(rows - 1));
    const int i = std::min(int(u), columns - 2), j = std::min(int(v), rows - 2);
    const double s = u - i, t = v - j;
    const double a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
    // Each cell is cut from its south-west to its north-east corner.
    return s >= t ? a + s * (b - a) + t * (d - b) : a + t * (c - a) + s * (d - c);
}

glm::vec3 HeightField::normal(int i, int j) const {
    const int west = std::max(i - 1, 0), east = std::min(i + 1, columns - 1), south = std::max(j - 1, 0), north = std::min(j + 1, rows - 1);
    const double dx = (double(at(east, j)) - at(west, j)) / ((east - west) * spacing);
    const double dy = (double(at(i, north)) - at(i, south)) / ((north - south) * spacing);
    return glm::vec3(glm::normalize(glm::dvec3(-dx, -dy, 1)));
}

double HeightField::slope(double px, double py) const {
    const double h = spacing / 2;
    const double dx = height(px + h, py) - height(px - h, py), dy = height(px, py + h) - height(px, py - h);
    return std::sqrt(dx * dx + dy * dy) / spacing;
}

void HeightField::stretch(double relief) {
    const auto [lo, hi] = std::minmax_element(heights.begin(), heights.end());
    const double base = *lo, range = double(*hi) - *lo;
    for (float& z : heights) z = range > 0 ? float((double(z) - base) / range * relief) : 0.0f;
}

Mesh terrainTile(const HeightField& field, int i0, int j0, int i1, int j1, int step, double skirt, glm::dvec2& centre) {
    centre = 0.5 * glm::dvec2(field.x(i0) + field.x(i1), field.y(j0) + field.y(j1));
    Mesh mesh;
    const auto add = [&](int i, int j, float z, const glm::vec3& normal) {
        mesh.positions.emplace_back(float(field.x(i) - centre.x), float(field.y(j) - centre.y), z);
        mesh.normals.push_back(normal);
        return uint32_t(mesh.positions.size() - 1);
    };
    const auto n = uint32_t((i1 - i0) / step);
    float lowest = field.at(i0, j0);
    for (int j = j0; j <= j1; j += step)
        for (int i = i0; i <= i1; i += step) {
            add(i, j, field.at(i, j), field.normal(i, j));
            lowest = std::min(lowest, field.at(i, j));
        }
    constexpr uint32_t kStripe = 12;  // columns per pass: a row of it stays in a GPU's vertex cache
    const auto m = uint32_t((j1 - j0) / step);
    for (uint32_t stripe = 0; stripe < n; stripe += kStripe)
        for (uint32_t j = 0; j < m; ++j)
            for (uint32_t i = stripe; i < std::min(n, stripe + kStripe); ++i) {
                const uint32_t a = j * (n + 1) + i, b = a + n + 1;
                mesh.indices.insert(mesh.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
            }

    // The border, counter-clockwise seen from above, with the walls below it.
    std::vector<glm::ivec2> border;
    for (int i = i0; i < i1; i += step) border.emplace_back(i, j0);
    for (int j = j0; j < j1; j += step) border.emplace_back(i1, j);
    for (int i = i1; i > i0; i -= step) border.emplace_back(i, j1);
    for (int j = j1; j > j0; j -= step) border.emplace_back(i0, j);
    const float floor = lowest - float(skirt);
    const uint32_t middle = uint32_t(mesh.positions.size());
    mesh.positions.emplace_back(0.0f, 0.0f, floor);
    mesh.normals.emplace_back(0, 0, -1);
    for (size_t k = 0; k < border.size(); ++k) {
        const glm::ivec2 p = border[k], q = border[(k + 1) % border.size()];
        const glm::vec3 outward = glm::normalize(glm::vec3(float(q.y - p.y), float(p.x - q.x), 0));
        const uint32_t a = add(p.x, p.y, field.at(p.x, p.y), outward), b = add(q.x, q.y, field.at(q.x, q.y), outward);
        const uint32_t c = add(p.x, p.y, floor, outward), d = add(q.x, q.y, floor, outward);
        const uint32_t e = add(p.x, p.y, floor, {0, 0, -1}), f = add(q.x, q.y, floor, {0, 0, -1});
        mesh.indices.insert(mesh.indices.end(), {a, c, d, a, d, b, middle, f, e});
    }
    return mesh;
}

}  // namespace dapple::scenegen
