#pragma once

#include "scenegen/plants/skeleton.h"

namespace dapple::scenegen {

struct Wind {
    double strength = 0;               ///< 0: still air; 1: a gale
    glm::dvec2 direction{1, 0};        ///< unit, that it blows to, in the tree's own space
    double time = 0;                   ///< seconds
};

/// Bends every stem to the wind and lets it swing about that bend: thinner stems farther and faster, each in a phase of
/// its own that `seed` gives. Lengths along stems stay, and children go along with their parent.
void sway(Skeleton& skeleton, const Wind& wind, uint64_t seed);

}  // namespace dapple::scenegen
