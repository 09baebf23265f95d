#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

/// Metres from `point` to the nearest eye of the scene's views; infinite without any. What stands far from every view may have
/// a coarser level of detail: no picture shows it from near by.
double viewDistance(const Scene& scene, const glm::dvec3& point);

}  // namespace dapple::scenegen
