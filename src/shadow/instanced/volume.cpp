#include "shadow/instanced/volume.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {

std::array<uint32_t, 72> boxShadowVolume() {
    constexpr uint32_t x = 1, y = 2, z = 4, moved = 8;
    constexpr uint32_t quads[12][4] = {
        // toward the sun
        {0, z, y + z, y}, {0, x, x + z, z}, {0, y, x + y, x},
        // away from it
        {x + moved, x + y + moved, x + y + z + moved, x + z + moved},
        {y + moved, y + z + moved, x + y + z + moved, x + y + moved},
        {z + moved, x + z + moved, x + y + z + moved, y + z + moved},
        // along the silhouette
        {x, x + y, x + y + moved, x + moved}, {x + y, y, y + moved, x + y + moved}, {y, y + z, y + z + moved, y + moved},
        {y + z, z, z + moved, y + z + moved}, {z, x + z, x + z + moved, z + moved}, {x + z, x, x + moved, x + z + moved}};
    std::array<uint32_t, 72> corners{};
    for (size_t q = 0; q < 12; ++q) {
        const size_t order[6] = {0, 1, 2, 0, 2, 3};
        for (size_t i = 0; i < 6; ++i) corners[q * 6 + i] = quads[q][order[i]];
    }
    return corners;
}

Extrusion extrusionFor(const base::DBox& sceneBox, const glm::dvec3& light) {
    if (sceneBox.empty()) return {};
    double farthest = -1e300, nearest = 1e300;
    for (int corner = 0; corner < 8; ++corner) {
        farthest = std::max(farthest, glm::dot(sceneBox.corner(corner), light));
        nearest = std::min(nearest, glm::dot(sceneBox.corner(corner), light));
    }
    return {farthest - nearest, sceneBox.lo.z - 1e-3 * glm::length(sceneBox.size())};
}

RotationSample sampleRotation(double yaw, int count) {
    const double turns = yaw / (2 * std::numbers::pi);
    double position = (turns - std::floor(turns)) * count;  // [0, count], the end by rounding only
    // An angle stored in float that was meant for a map is that map's: a 2e-6th of a step is below its rounding.
    const double nearest = std::round(position);
    if (std::abs(position - nearest) < 2e-6 * count) position = nearest;
    const double first = std::floor(position);
    return {static_cast<uint32_t>(first) % static_cast<uint32_t>(count), static_cast<float>(position - first)};
}

}  // namespace dapple::shadow
