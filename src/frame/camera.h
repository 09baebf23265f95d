#pragma once

#include "base/math.h"
#include "scenegen/scene.h"

#include <array>

namespace dapple::frame {

/// A view with a resolution. All matrices are relative to the eye (the eye is the origin, world axes), so
/// they hold in float wherever the scene lies. Reversed z: depth 1 at `near`, 0 at `far`, clip z in [0, 1].
struct Camera {
    Camera(const scenegen::View& view, int width, int height);

    glm::dvec3 eye;                 ///< metres from Scene::origin
    glm::dvec3 right, up, forward;  ///< orthonormal
    double near, far;
    double tanX, tanY;              ///< tangents of half the fields of view
    int width, height;
    glm::dvec2 shift{0, 0};  ///< pixels by which the picture's points lie to the right of the pixels' centres, and above them
    glm::dmat4 clipFromRelative;

    /// The same view through points beside the pixels' centres: `pixels` to the right and upwards.
    void shiftBy(const glm::dvec2& pixels);

    /// Metres along `forward` of a depth-buffer value.
    double eyeDepth(double depth) const { return near * far / (depth * (far - near) + near); }
    /// Point relative to the eye at a pixel centre; (0,0) is the lower left pixel.
    glm::dvec3 relativePoint(int x, int y, double depth) const;
    /// Planes of the frustum: dot(plane.xyz, p) + plane.w ≥ 0 inside, p relative to the eye; unit normals.
    std::array<glm::dvec4, 6> planes() const;
    /// False only if the box (relative to the eye) lies wholly outside one plane.
    bool mayContain(const base::DBox& relativeBox) const;
};

}  // namespace dapple::frame
