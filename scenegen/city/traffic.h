#pragma once

#include "scenegen/city/plan.h"
#include "scenegen/scene.h"

#include <span>

namespace dapple::scenegen::city {

inline constexpr double kCarHalfLength = 2.22, kCarHalfWidth = 0.92;  ///< metres, of furniture's cars
inline constexpr double kParkedReach = 2.25;  ///< metres from the kerb that parked cars take
inline constexpr double kHeadway = 10.5;      ///< metres from one car's middle to the next one's, at least
inline constexpr double kMiddle = 1.95;       ///< metres from a street's centre line to that of its first lane

inline constexpr double kLaneWidth = 3.4;     ///< metres

/// Lanes in each direction, 1 or 2.
int lanesEachWay(const Street& street);

/// Where cars drive: from one end of a straight street to the other, on its right.
struct Lane {
    glm::dvec2 from{0}, to{0};  ///< middle of a car at the ends: nowhere between them it touches a kerb or a parked car
    double speed = 0;           ///< metres per second: 8 in the narrowest streets, 14 in the widest
};

/// Streets too short for a few car lengths have none.
std::vector<Lane> lanesOf(const Plan& plan);

/// Appends `perKm` cars to each kilometre of lane, as moving instances of some of `cars` (heading +x). Those of one lane
/// have its speed and keep kHeadway, the way from the last to the first included, so that they never meet. Cars of
/// crossing streets take no notice of each other.
void addTraffic(Scene& scene, const Plan& plan, std::span<const uint32_t> cars, double perKm, uint64_t seed);

}  // namespace dapple::scenegen::city
