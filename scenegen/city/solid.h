#pragma once

#include "scenegen/city/region.h"
#include "scenegen/scene.h"

#include <functional>
#include <optional>
#include <span>

/// Closed, oriented solids with flat faces, appended to meshes. Solids of one mesh may overlap, as buried ends do, but
/// never share a corner: each stays a 2-manifold of its own when equal positions are welded.
namespace dapple::scenegen::city {

/// Appends a plane convex polygon, counter-clockwise seen from outside; its normal is Newell's.
void addFace(Mesh& mesh, std::span<const glm::dvec3> corners);
inline void addFace(Mesh& mesh, std::initializer_list<glm::dvec3> corners) { addFace(mesh, std::span(corners.begin(), corners.size())); }

/// Between two parallel convex polygons of equally many corners, both counter-clockwise seen from `high`'s outside.
void addLoft(Mesh& mesh, std::span<const glm::dvec3> low, std::span<const glm::dvec3> high);

void addBox(Mesh& mesh, const glm::dvec3& lo, const glm::dvec3& hi);

/// A box that tapers: rectangle lo at height lo.z, hi at hi.z, given as {x0, y0, x1, y1}.
void addFrustum(Mesh& mesh, const glm::dvec4& lo, double zLo, const glm::dvec4& hi, double zHi);

/// Cylinder or cone about an axis from `a` to `b`; radii > 0.
void addCone(Mesh& mesh, const glm::dvec3& a, double radiusA, const glm::dvec3& b, double radiusB, int sides);

/// Upright prism over a convex region. Floor and roof are heights over the plan, each linear on either side of `fold`
/// (a ridge), or everywhere without one. Corners within 2 cm of the fold count as on it.
struct Prism {
    double floor = 0, roof = 1;  ///< at eaves height: where distance(eaves) = 0
    const Line* eaves = nullptr; ///< heights rise with the distance to its left, and fall again beyond the fold
    double slope = 0;            ///< of the roof; `floorSlope` of the floor
    double floorSlope = 0;
    double fold = 0;             ///< distance of the ridge from the eaves; ≤ 0: none
};
void addPrism(Mesh& mesh, const Region& region, const Prism& prism);
inline void addPrism(Mesh& mesh, const Region& region, double floor, double roof) { addPrism(mesh, region, {.floor = floor, .roof = roof}); }

/// Ring between two rectangles about the same centre: a parapet.
void addRing(Mesh& mesh, const glm::dvec2& lo, const glm::dvec2& hi, double thickness, double floor, double roof);

}  // namespace dapple::scenegen::city
