#pragma once

#include <glm/glm.hpp>

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

}  // namespace dapple::scenegen::city
