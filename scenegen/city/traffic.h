#pragma once

#include "scenegen/city/plan.h"
#include "scenegen/scene.h"

#include <span>

namespace dapple::scenegen::city {

inline constexpr double kCarHalfLength = 2.22, kCarHalfWidth = 0.92;  ///< metres, of furniture's cars
inline constexpr double kParkedReach = 2.25;  ///< metres from the kerb that parked cars take
inline constexpr double kParkingMargin = 10;  ///< metres from a kerb's ends, within which nobody parks (the middle of a car)
inline constexpr double kHeadway = 10.5;      ///< metres from one car's middle to the next one's, at least
inline constexpr double kMiddle = 1.95;       ///< metres from a street's centre line to that of its first lane

inline constexpr double kLaneWidth = 3.4;     ///< metres

/// Lanes in each direction, 1 or 2.
int lanesEachWay(const Street& street);

/// Where cars drive: along each lane of a straight street, on its right, and by a turn at its end back along the lane opposite.
/// Nowhere a car (4.4 m long) touches a kerb or a place where cars park. Turns are as wide as the street allows, up to a radius of 4.8 m, and
/// 2.9 m at least (a London taxi's). 8 m/s in the narrowest streets, 14 in the widest, turns included: whoever
/// slowed down there would be run into by the next. Streets too short for a few car lengths have none.
std::vector<Motion> loopsOf(const Plan& plan);

/// Appends `perKm` cars to each kilometre of lane, as moving instances of some of `cars` (heading +x). Those of one loop
/// have its speed and keep kHeadway along it, so that they never meet. Cars of crossing streets take no notice of each other.
void addTraffic(Scene& scene, const Plan& plan, std::span<const uint32_t> cars, double perKm, uint64_t seed);

}  // namespace dapple::scenegen::city
