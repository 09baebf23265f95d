#pragma once

#include "scenegen/city/rings.h"

#include <array>
#include <cstdint>
#include <vector>

namespace dapple::scenegen::city {

/// Counter-clockwise triangles of what an odd number of rings encloses: a polygon and its holes, rings that touch at
/// corners or along edges, and rings with bridges (edges that run there and back). An outline runs counter-clockwise,
/// a hole clockwise. Corners are numbered through the rings; where several lie at one place, each triangle gets the one
/// whose angle it fills. A corner on another edge splits that edge. Corners within a millionth of the polygon's size
/// of an edge that they cross count as on it.
///
/// Takes about n log n steps, on combs, spirals and stars too. Empty when rings cross, enclose nothing or hold a
/// coordinate that is not finite; no coordinate may exceed 1e75 (products of four must stay finite).
std::vector<std::array<uint32_t, 3>> triangulate(const std::vector<Ring>& rings);

}  // namespace dapple::scenegen::city
