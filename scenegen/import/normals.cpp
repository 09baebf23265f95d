#include "scenegen/import/normals.h"

#include "scenegen/lod/half_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <utility>

namespace dapple::scenegen {
namespace {

constexpr size_t kMany = 64;  ///< faces round a position; beyond, those that face alike are added up first

/// Sums of faces that face alike to 0.1 degrees: a roof of 50,000 corners may have one that all its triangles share.
std::vector<glm::dvec3> alike(const std::vector<glm::dvec3>& normals, std::span<const uint32_t> faces) {
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
    const std::vector<uint32_t> welded = weldedVertices(mesh.positions);
    std::vector<glm::dvec3> faceNormals;  // twice the area long
    std::vector<uint32_t> begin(mesh.positions.size() + 1, 0);  // of each position's faces
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const uint32_t* v = &mesh.indices[i];
        const glm::dvec3 a(mesh.positions[v[0]]), b(mesh.positions[v[1]]), c(mesh.positions[v[2]]);
        faceNormals.push_back(glm::cross(b - a, c - a));
        for (int k = 0; k < 3; ++k) ++begin[welded[v[k]] + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<uint32_t> faces(mesh.indices.size()), end(begin.begin(), begin.end() - 1);
    for (size_t i = 0; i < mesh.indices.size(); ++i) faces[end[welded[mesh.indices[i]]]++] = uint32_t(i / 3);
    const auto facesAt = [&](uint32_t p) { return std::span(faces).subspan(begin[p], end[p] - begin[p]); };
    std::map<uint32_t, std::vector<glm::dvec3>> crowded;
    for (uint32_t p = 0; p < end.size(); ++p)
        if (facesAt(p).size() > kMany) crowded.emplace(p, alike(faceNormals, facesAt(p)));

    Mesh out;
    out.material = mesh.material;
    const double limit = std::cos(glm::radians(creaseDegrees));
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> newest(mesh.positions.size(), kNone), older;  // a chain of new vertices for each old one
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        const uint32_t v = mesh.indices[i], p = welded[v];
        const glm::dvec3 own = faceNormals[i / 3];
        glm::dvec3 sum(0);
        const auto add = [&](const glm::dvec3& n) {
            if (glm::dot(own, n) >= limit * glm::length(own) * glm::length(n)) sum += n;
        };
        if (const auto it = crowded.find(p); it != crowded.end()) std::ranges::for_each(it->second, add);
        else
            for (const uint32_t f : facesAt(p)) add(faceNormals[f]);
        const glm::vec3 n = glm::length(sum) > 0 ? glm::vec3(glm::normalize(sum)) : glm::vec3(0);
        uint32_t vertex = newest[v];
        while (vertex != kNone && out.normals[vertex] != n) vertex = older[vertex];
        if (vertex == kNone) {
            vertex = uint32_t(out.positions.size());
            older.push_back(std::exchange(newest[v], vertex));
            out.positions.push_back(mesh.positions[v]);
            out.normals.push_back(n);
            if (!mesh.uvs.empty()) out.uvs.push_back(mesh.uvs[v]);
        }
        out.indices.push_back(vertex);
    }
    mesh = std::move(out);
}

}  // namespace dapple::scenegen
