#pragma once

#include "base/math.h"

#include <array>
#include <cstdint>

namespace dapple::shadow {

/// Triangles of the bounding shadow volume of a box under parallel light, once the box's axes are mirrored so that
/// the light has no negative component: then its topology is fixed. Three faces toward the sun stay, three away
/// from it are moved along the light, six quads join them along the hexagonal silhouette: 24 triangles.
/// Bits 0…2 of an entry pick the corner (1 = the side the light travels to), bit 3 says moved.
/// Counter-clockwise seen from outside.
std::array<uint32_t, 72> boxShadowVolume();

/// How far shadow volumes are extruded, so that they end behind every receiver.
struct Extrusion {
    double most = 0;   ///< metres along the light: enough for every caster
    double floor = 0;  ///< height below which there is no receiver; a caster is extruded no farther than it takes to get there
};
/// `sceneBox`: relative to the eye, as the floor is; `light`: unit.
Extrusion extrusionFor(const base::DBox& sceneBox, const glm::dvec3& light);

/// The two maps about a yaw and the weight of the second: maps stand at φ_k = 2πk/count.
struct RotationSample {
    uint32_t first = 0;  ///< in [0, count); the second map is (first + 1) mod count
    float weight = 0;    ///< in [0, 1)
};
/// `yaw` in radians, any finite value.
RotationSample sampleRotation(double yaw, int count);

}  // namespace dapple::shadow
