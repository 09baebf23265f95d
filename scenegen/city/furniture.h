#pragma once

#include "scenegen/city/plan.h"
#include "scenegen/scene.h"

namespace dapple::scenegen::city {

/// What stands in streets: trees, lamps, signs, parked cars, road markings.
struct FurnitureOptions {
    uint64_t seed = 1;
    size_t treeTriangles = 0;  ///< per tree; 0: no trees
    double cars = 0.7;         ///< share of parking places that are taken
};

/// Appends their prototypes and materials, and an instance for each. Deterministic.
/// Keeps clear of crossings; crowns keep clear of the lots' edges.
void addFurniture(Scene& scene, const Plan& plan, const FurnitureOptions& options);

/// Trees in courtyards and parks: at each of `places` (z = foot).
void addTrees(Scene& scene, const std::vector<glm::dvec3>& places, double crownRadius, const FurnitureOptions& options);

}  // namespace dapple::scenegen::city
