#pragma once

#include "scenegen/city/plan.h"
#include "scenegen/scene.h"

namespace dapple::scenegen::city {

/// What stands in streets: trees, lamps, signs, parked and moving cars, road markings.
struct FurnitureOptions {
    uint64_t seed = 1;
    size_t treeTriangles = 0;  ///< per tree; 0: no trees
    double cars = 0.7;         ///< share of parking places that are taken
    double traffic = 0;        ///< moving cars per kilometre of lane
    double nearDetail = 0;     ///< metres from a view beyond which trees have a coarser level of detail; 0: nowhere
    bool night = false;        ///< lamps are lit
};

struct TreePlace {
    glm::dvec3 foot;
    double crownRadius;  ///< metres, at most
};

/// Appends their prototypes and materials, and an instance for each. `trees` stand already, in yards and parks; those of
/// the pavements are added, with crowns that mostly keep clear of the fronts.
void addFurniture(Scene& scene, const Plan& plan, std::vector<TreePlace> trees, const FurnitureOptions& options);

}  // namespace dapple::scenegen::city
