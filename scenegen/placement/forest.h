#pragma once

#include "scenegen/placement/poisson.h"
#include "scenegen/scene.h"

#include <functional>
#include <span>
#include <vector>

namespace dapple::scenegen {

/// The trees of one species.
struct Stand {
    double share = 1;                        ///< of all trees, relative to the other stands
    glm::dvec2 scale{1};                     ///< lowest and highest scale of an instance
    glm::dvec2 altitude{-1e300, 1e300};      ///< metres, where it grows
    double steepest = 1e300;                 ///< rise over run, where it still grows
    std::vector<uint32_t> individuals;       ///< prototypes
    std::vector<double> crownRadii;          ///< metres, parallel to `individuals`
};

/// Where trees may stand: the square [-half, half]² without what is not open.
struct Site {
    double half = 0;                                         ///< metres
    std::function<double(const glm::dvec2&)> height, slope;  ///< metres; rise over run
    std::function<bool(const glm::dvec2&)> open;
};

/// `trees` instances of random individual, yaw and scale, each `spacing` crown radii from its neighbours where there is
/// room; fewer if they thin themselves (Deussen et al. 1998: the smaller of two that meet dies). Each species has its
/// share of what is sown, to within one tree. Throws UsageError if they cannot stand.
std::vector<Instance> plantForest(size_t trees, double spacing, Crowding crowding, uint64_t seed, std::span<const Stand> stands, const Site& site);

}  // namespace dapple::scenegen
