#pragma once

#include <glm/glm.hpp>

#include <vector>

namespace dapple::scenegen::city {

using Ring = std::vector<glm::dvec2>;

/// Twice the signed area: positive when counter-clockwise.
double twiceArea(const Ring& ring);

/// Even-odd rule.
bool contains(const Ring& ring, const glm::dvec2& p);

}  // namespace dapple::scenegen::city
