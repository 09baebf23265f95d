#pragma once

#include "scenegen/city/plan.h"
#include "scenegen/scene.h"

namespace dapple::scenegen::city {

/// Appends walk0 …: along the widest and longest streets, 1.7 m above the roadway; then `above`, from the south-west.
void addViews(Scene& scene, const Plan& plan, int count, double fovY);

}  // namespace dapple::scenegen::city
