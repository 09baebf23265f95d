#pragma once

#include "visibility/view.h"

namespace dapple::visibility {

/// Reversed z, as frame::Camera has it.
inline glm::dmat4 cameraMatrix(const glm::dvec3& forward, double tanX, double tanY, double near, double far) {
    const glm::dvec3 f = glm::normalize(forward), right = glm::normalize(glm::cross(f, {0, 0, 1})), up = glm::cross(right, f);
    const double a = -near / (far - near), b = near * far / (far - near);
    return glm::transpose(glm::dmat4(glm::dvec4(right / tanX, 0), glm::dvec4(up / tanY, 0), glm::dvec4(f * a, b), glm::dvec4(f, 0)));
}

/// Orthographic map about the eye: ± `half` across, from `zLo` to `zHi` along the light (metres, relative). `warp` > 0: x, y
/// and z divided by w = 1 + warp · y / half, as a light-space perspective map divides them.
inline glm::dmat4 sunMatrix(const glm::dvec3& direction, double half, double zLo, double zHi, double warp = 0) {
    const glm::dvec3 u = glm::normalize(glm::cross(direction, {0.1, 1, 0.2})), v = glm::cross(u, direction);
    return glm::transpose(glm::dmat4(glm::dvec4(u / half, 0), glm::dvec4(v / half, 0), glm::dvec4(direction / (zHi - zLo), -zLo / (zHi - zLo)), glm::dvec4(v * (warp / half), 1)));
}

}  // namespace dapple::visibility
