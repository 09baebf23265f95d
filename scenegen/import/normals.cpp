#include "scenegen/import/normals.h"

#include <array>
#include <map>
#include <tuple>

namespace dapple::scenegen {

void generateNormals(Mesh& mesh, double creaseDegrees) {
    using Point = std::array<float, 3>;
    const auto pointOf = [&](uint32_t v) { return Point{mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z}; };
    std::vector<glm::dvec3> faceNormals;  // twice the area long
    std::map<Point, std::vector<uint32_t>> facesAt;
    for (uint32_t f = 0; f < mesh.triangles(); ++f) {
        const uint32_t* v = &mesh.indices[size_t(f) * 3];
        const glm::dvec3 a(mesh.positions[v[0]]), b(mesh.positions[v[1]]), c(mesh.positions[v[2]]);
        faceNormals.push_back(glm::cross(b - a, c - a));
        for (int k = 0; k < 3; ++k) facesAt[pointOf(v[k])].push_back(f);
    }

    Mesh out;
    out.material = mesh.material;
    const double limit = std::cos(glm::radians(creaseDegrees));
    std::map<std::tuple<uint32_t, float, float, float>, uint32_t> known;
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        const uint32_t v = mesh.indices[i];
        const glm::dvec3 own = faceNormals[i / 3];
        glm::dvec3 sum(0);
        for (const uint32_t f : facesAt[pointOf(v)])
            if (glm::dot(own, faceNormals[f]) >= limit * glm::length(own) * glm::length(faceNormals[f])) sum += faceNormals[f];
        const glm::vec3 n = glm::length(sum) > 0 ? glm::vec3(glm::normalize(sum)) : glm::vec3(0);
        const auto [it, isNew] = known.emplace(std::tuple(v, n.x, n.y, n.z), uint32_t(out.positions.size()));
        if (isNew) {
            out.positions.push_back(mesh.positions[v]);
            out.normals.push_back(n);
            if (!mesh.uvs.empty()) out.uvs.push_back(mesh.uvs[v]);
        }
        out.indices.push_back(it->second);
    }
    mesh = std::move(out);
}

}  // namespace dapple::scenegen
