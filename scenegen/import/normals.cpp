#include "scenegen/import/normals.h"

#include <array>
#include <cmath>
#include <map>
#include <tuple>

namespace dapple::scenegen {
namespace {

constexpr size_t kMany = 64;  ///< faces round a position; beyond, those that face alike are added up first

/// Sums of faces that face alike to 0.1 degrees: a roof of 50,000 corners may have one that all its triangles share.
std::vector<glm::dvec3> alike(const std::vector<glm::dvec3>& normals, const std::vector<uint32_t>& faces) {
    std::map<std::array<long, 3>, glm::dvec3> sums;
    for (const uint32_t f : faces) {
        const double length = glm::length(normals[f]);
        if (!(length > 0)) continue;
        const glm::dvec3 n = normals[f] * (512 / length);
        sums[{std::lround(n.x), std::lround(n.y), std::lround(n.z)}] += normals[f];
    }
    std::vector<glm::dvec3> list;
    for (const auto& [key, sum] : sums) list.push_back(sum);
    return list;
}

}  // namespace

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

    std::map<Point, std::vector<glm::dvec3>> crowded;
    for (const auto& [point, faces] : facesAt)
        if (faces.size() > kMany) crowded.emplace(point, alike(faceNormals, faces));

    Mesh out;
    out.material = mesh.material;
    const double limit = std::cos(glm::radians(creaseDegrees));
    std::map<std::tuple<uint32_t, float, float, float>, uint32_t> known;
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        const uint32_t v = mesh.indices[i];
        const glm::dvec3 own = faceNormals[i / 3];
        glm::dvec3 sum(0);
        const auto add = [&](const glm::dvec3& n) {
            if (glm::dot(own, n) >= limit * glm::length(own) * glm::length(n)) sum += n;
        };
        const Point point = pointOf(v);
        if (const std::vector<uint32_t>& faces = facesAt[point]; faces.size() <= kMany)
            for (const uint32_t f : faces) add(faceNormals[f]);
        else
            for (const glm::dvec3& n : crowded.at(point)) add(n);
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
