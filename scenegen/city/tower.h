#pragma once

#include "scenegen/city/facade.h"

#include <compare>
#include <cstdint>

/// Buildings of a gridded city (manhattan): walk-ups with a cornice, and towers that step back as they rise, as New
/// York's zoning of 1916 wants it. Outlines are whole bays, so that equal parcels share one prototype.
namespace dapple::scenegen::city {

inline constexpr int kTowerStyles = 4;

struct TowerKind {
    int width = 4, depth = 5;     ///< bays along the front, away from it
    bool left = false, right = false, rear = false;  ///< sides on a street beside the front, seen from above with the front at the lower edge
    int style = 0;                ///< brick, limestone, concrete, glass
    int rise = 0;                 ///< 0: midtown's lesser, 1: tall, 2: tallest where the parcel is large enough; walk-ups: a variant

    auto operator<=>(const TowerKind&) const = default;
};

/// The outline's centre on the ground is the origin; the front looks to -y. Closed solids, by material. `seed` decides
/// storeys and steps. As massing it has no roof boxes either.
Parts towerParts(const TowerKind& kind, uint64_t seed, Detail detail = Detail::near);

}  // namespace dapple::scenegen::city
