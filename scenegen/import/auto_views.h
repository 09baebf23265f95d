#pragma once

#include "scenegen/scene.h"

#include <vector>

namespace dapple::scenegen {

/// Views for a scene that has none: "auto0" … on the ground, eyes 1.7 m above it, each looking from a free
/// spot under open sky along the most geometry in sight, well apart from each other; and "above", which
/// sees all of it. Deterministic. At least three ground views and `above`, for any scene with a triangle.
std::vector<View> chooseViews(const Scene& scene);

/// Far plane (metres) behind which the scene has nothing, seen from `eye` (metres from Scene::origin).
double chooseFar(const base::Box& sceneBox, const glm::dvec3& eye, double near);

}  // namespace dapple::scenegen
