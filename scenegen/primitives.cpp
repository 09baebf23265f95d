#include "scenegen/primitives.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace dapple::scenegen {

Mesh boxMesh(const glm::vec3& size) {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0f, 1.0f}) {
            glm::vec3 n(0), u(0), v(0);
            n[axis] = sign, u[(axis + 1) % 3] = sign, v[(axis + 2) % 3] = 1;
            const auto base = uint32_t(mesh.positions.size());
            for (const glm::vec3& corner : {n - u - v, n + u - v, n + u + v, n - u + v}) {
                mesh.positions.push_back(0.5f * size * corner);
                mesh.normals.push_back(n);
            }
            for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + i);
        }
    return mesh;
}

Mesh sphereMesh(float radius, int refine) {
    const double a = 1, b = (1 + std::sqrt(5.0)) / 2;
    std::vector<glm::dvec3> points{{-a, b, 0}, {a, b, 0}, {-a, -b, 0}, {a, -b, 0}, {0, -a, b}, {0, a, b},
                                   {0, -a, -b}, {0, a, -b}, {b, 0, -a}, {b, 0, a}, {-b, 0, -a}, {-b, 0, a}};
    for (glm::dvec3& p : points) p = glm::normalize(p);
    std::vector<uint32_t> triangles{0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10, 7, 6, 7, 1, 8,
                                    3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10, 8, 6, 7, 9, 8, 1};
    for (int level = 0; level < refine; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t i, uint32_t j) {
            const auto [at, isNew] = middles.try_emplace(std::minmax(i, j), uint32_t(points.size()));
            if (isNew) points.push_back(glm::normalize(points[i] + points[j]));
            return at->second;
        };
        std::vector<uint32_t> finer;
        for (size_t t = 0; t < triangles.size(); t += 3) {
            const uint32_t i = triangles[t], j = triangles[t + 1], k = triangles[t + 2];
            const uint32_t ij = middle(i, j), jk = middle(j, k), ki = middle(k, i);
            finer.insert(finer.end(), {i, ij, ki, ij, j, jk, ki, jk, k, ij, jk, ki});
        }
        triangles = std::move(finer);
    }
    Mesh mesh;
    mesh.indices = std::move(triangles);
    for (const glm::dvec3& p : points) {
        mesh.positions.emplace_back(p * double(radius));
        mesh.normals.emplace_back(p);
    }
    return mesh;
}

}  // namespace dapple::scenegen
