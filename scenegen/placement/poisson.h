#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace dapple::scenegen {

/// Poisson disk sampling with a radius per point, by dart throwing over a grid: points i and j of `radii` (metres) end
/// at least f·(radii[i] + radii[j]) apart in the square [-half, half]², where 0 < f ≤ 1 is 1 unless that is too tight;
/// then f shrinks by steps of 0.9. `allowed` keeps points off paths. Larger disks are placed first.
/// Throws UsageError when no room is left at f < 0.2.
std::vector<glm::dvec2> poissonDisks(std::span<const double> radii, double half, uint64_t seed,
                                     const std::function<bool(const glm::dvec2&)>& allowed);

}  // namespace dapple::scenegen
