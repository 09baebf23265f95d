#pragma once

#include "scenegen/scene.h"

#include <functional>
#include <span>

/// Closed, oriented solids with curved faces and smooth normals, appended to meshes as those of solid.h are.
namespace dapple::scenegen::city {

/// Turned about the vertical through `foot`. `profile`: (radius > 0, height over the foot), upwards or level from point
/// to point, no two equal; edges sharper than 37° stay sharp. Flat at both ends.
void addLathe(Mesh& mesh, const glm::dvec3& foot, std::span<const glm::dvec2> profile, int sides);

/// A wall over an opening with a round arch: |x| ≤ width / 2, |y| ≤ thickness / 2, from the springing up to `top`.
struct ArchPanel {
    double width, radius, springing, top, thickness;  ///< metres; radius < width / 2, springing + radius < top
};
void addArchPanel(Mesh& mesh, const ArchPanel& panel, int segments);

/// Half a ring in the plane of x and z about (0, springing), radii inner … outer, from y = front to y = back.
void addArchRing(Mesh& mesh, double springing, double inner, double outer, double front, double back, int segments);

/// A sheet of cloth along surface(u, v), u and v from 0 to 1: that surface ± half the thickness.
void addSheet(Mesh& mesh, int columns, int rows, double thickness, const std::function<glm::dvec3(double u, double v)>& surface);

}  // namespace dapple::scenegen::city
