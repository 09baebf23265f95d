#pragma once

#include "base/detmath.h"
#include "scenegen/plants/skeleton.h"

#include <algorithm>
#include <cmath>

/// Right-handed frames with the stem's direction as their z column.
namespace dapple::scenegen {

inline glm::dmat3 rotateX(const glm::dmat3& f, double degrees) {
    const auto [s, c] = base::det::sinCos(degrees * base::det::kDegree);
    return {f[0], f[1] * c + f[2] * s, f[2] * c - f[1] * s};
}

inline glm::dmat3 rotateZ(const glm::dmat3& f, double degrees) {
    const auto [s, c] = base::det::sinCos(degrees * base::det::kDegree);
    return {f[0] * c + f[1] * s, f[1] * c - f[0] * s, f[2]};
}

/// Turns all columns about the world's vertical.
inline glm::dmat3 turnAboutVertical(const glm::dmat3& f, double degrees) {
    const auto [s, c] = base::det::sinCos(degrees * base::det::kDegree);
    glm::dmat3 r;
    for (int i = 0; i < 3; ++i) r[i] = {c * f[i].x - s * f[i].y, s * f[i].x + c * f[i].y, f[i].z};
    return r;
}

/// Frame with the given z column whose x column is nearest to `x`.
inline glm::dmat3 frameAlong(const glm::dvec3& z, const glm::dvec3& x) {
    const glm::dvec3 across = glm::normalize(x - z * glm::dot(x, z));
    return {across, glm::cross(z, across), z};
}

/// Frames from the mean of the neighbouring directions, parallel-transported, so that the cage does not twist.
void orientRings(std::vector<Ring>& rings);

}  // namespace dapple::scenegen
