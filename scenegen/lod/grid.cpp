#include "scenegen/lod/grid.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr double kSteps = 65534;          ///< rounding may add one at either end
constexpr double kCoarsest = 1.0 / 256;  ///< metres

glm::vec3 facet(const std::vector<glm::vec3>& p, const uint32_t* triangle) {
    return glm::cross(p[triangle[1]] - p[triangle[0]], p[triangle[2]] - p[triangle[0]]);
}

}  // namespace

void snapToGrid(Mesh& mesh) {
    base::Box box;
    for (const glm::vec3& p : mesh.positions) box.extend(p);
    if (box.empty()) return;
    const glm::dvec3 size(box.size());
    const double extent = std::max({size.x, size.y, size.z});
    if (extent <= 0) return;
    int exponent = 0;
    const double mantissa = std::frexp(extent / kSteps, &exponent);  // in [½, 1): the next power of two is 2^exponent
    const double step = std::ldexp(1.0, mantissa == 0.5 ? exponent - 1 : exponent);
    if (step > kCoarsest) return;
    std::vector<glm::vec3> moved;
    moved.reserve(mesh.positions.size());
    for (const glm::vec3& p : mesh.positions) moved.emplace_back(glm::round(glm::dvec3(p) / step) * step);
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 before(facet(mesh.positions, &mesh.indices[i])), after(facet(moved, &mesh.indices[i]));
        if (glm::dot(before, after) < 0.5 * glm::length(before) * glm::length(after) || (after == glm::dvec3(0) && before != glm::dvec3(0))) return;
    }
    mesh.positions = std::move(moved);
}

bool isQuadList(const Mesh& mesh) {
    constexpr size_t kQuad[6] = {0, 1, 2, 0, 2, 3};
    if (mesh.indices.size() % 6 != 0 || mesh.indices.size() / 6 * 4 != mesh.positions.size()) return false;
    for (size_t i = 0; i < mesh.indices.size(); ++i)
        if (mesh.indices[i] != i / 6 * 4 + kQuad[i % 6]) return false;
    return true;
}

}  // namespace dapple::scenegen
