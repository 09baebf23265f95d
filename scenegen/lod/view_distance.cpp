#include "scenegen/lod/view_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dapple::scenegen {

double viewDistance(const Scene& scene, const glm::dvec3& point) {
    double nearest2 = std::numeric_limits<double>::infinity();
    for (const View& view : scene.views) nearest2 = std::min(nearest2, glm::dot(view.eye - point, view.eye - point));
    return std::sqrt(nearest2);
}

}  // namespace dapple::scenegen
