#pragma once

#include "scenegen/scene.h"

/// How often closed surfaces wind round a point, by the signed crossings of a ray along +x: the oracle for "inside".
inline int windingNumber(const dapple::scenegen::Mesh& mesh, const glm::dvec3& p) {
    int winding = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        glm::dvec3 v[3];
        for (size_t k = 0; k < 3; ++k) v[k] = glm::dvec3(mesh.positions[mesh.indices[i + k]]) - p;
        double area[3];
        for (int k = 0; k < 3; ++k) area[k] = v[(k + 1) % 3].y * v[(k + 2) % 3].z - v[(k + 2) % 3].y * v[(k + 1) % 3].z;
        const bool all = (area[0] > 0) == (area[1] > 0) && (area[1] > 0) == (area[2] > 0);
        if (!all) continue;
        const double sum = area[0] + area[1] + area[2];
        if ((area[0] * v[0].x + area[1] * v[1].x + area[2] * v[2].x) / sum > 0) winding += sum > 0 ? 1 : -1;
    }
    return winding;
}
