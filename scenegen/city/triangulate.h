#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace dapple::scenegen::city {

using Ring = std::vector<glm::dvec2>;

/// Twice the signed area: positive when counter-clockwise.
double twiceArea(const Ring& ring);

/// Whether no two edges of one or two rings cross or touch, but for neighbours at their common corner.
bool isSimple(const Ring& ring);
bool areApart(const Ring& a, const Ring& b);

/// Even-odd rule.
bool contains(const Ring& ring, const glm::dvec2& p);

/// Triangles of a polygon with holes: the first ring counter-clockwise, the others clockwise within it, all simple and
/// apart. Corners are numbered through the rings. Holes are bridged to the outer ring (Eberly 2002, Triangulation by Ear
/// Clipping, section 5) and the fattest ear is cut each time. Empty when rounding leaves no ear.
std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Ring>& rings);

}  // namespace dapple::scenegen::city
