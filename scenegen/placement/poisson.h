#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace dapple::scenegen {

/// What happens where the disks do not fit.
enum class Crowding {
    shrink,  ///< they move closer together: the factor f below goes down by steps of 0.9
    thin,    ///< each has one place, drawn once: where a larger disk stands already it dies (self-thinning)
};

struct Disks {
    std::vector<uint32_t> kept;     ///< indices into the radii, ascending; all of them unless thinned
    std::vector<glm::dvec2> points; ///< metres, parallel to `kept`
};

/// Poisson disk sampling with a radius per point, by dart throwing over a grid: points i and j of `radii` (metres) end
/// at least f·(radii[i] + radii[j]) apart in the square [-half, half]², where 0 < f ≤ 1 is 1 unless that is too tight.
/// `allowed(i, p)` keeps point i off paths, or off slopes that it does not grow on. Larger disks are placed first.
/// Throws UsageError when no room is left at f < 0.2.
Disks poissonDisks(std::span<const double> radii, double half, uint64_t seed, Crowding crowding,
                   const std::function<bool(size_t, const glm::dvec2&)>& allowed);

}  // namespace dapple::scenegen
