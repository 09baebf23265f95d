#pragma once

#include "scenegen/plants/species.h"

#include <vector>

namespace dapple::scenegen {

/// A joint of a colonised tree; a parent stands before its children, the first has none (-1).
struct CrownNode {
    glm::dvec3 position;  ///< metres
    int parent = -1;
    double radius = 0;    ///< metres, by the pipe model: radiusⁿ is the sum of the children's
};

/// Space colonisation: Runions, Lane and Prusinkiewicz, "Modeling Trees with a Space Colonization Algorithm" (2007).
/// Attractors fill the crown, which is the species' pruning envelope in a tree of `height` metres; the trunk comes up
/// from the origin. Radii are scaled so that the foot has `radius` metres.
std::vector<CrownNode> colonise(const Species& species, double height, double radius, uint64_t seed);

}  // namespace dapple::scenegen
