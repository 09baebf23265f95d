#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace dapple::scenegen {

/// Appends the triangles of a polygon, as numbers of its corners, wound as it is. The polygon may be concave, and hold
/// holes that edges there and back join to its rim. It is cut as seen along its normal, so that it need not be quite
/// flat. Returns false when it cannot be cut, because it crosses itself: it is then a fan round its first corner.
bool cutPolygon(std::span<const glm::dvec3> corners, std::vector<std::array<uint32_t, 3>>& triangles);

/// What a reader notes when that happens.
inline constexpr const char* kCutAsFan = "polygons that cross themselves are cut as fans";

}  // namespace dapple::scenegen
