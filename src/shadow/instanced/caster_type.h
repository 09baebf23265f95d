#pragma once

#include "base/math.h"

#include <cstdint>
#include <vector>

namespace dapple::shadow {

/// Casters that share maps: the instances of a part, which is a prototype or a piece of one; or a single instance.
struct CasterType {
    uint32_t part = 0;           ///< index into gpuscene::Items::parts()
    uint32_t item = 0;           ///< index into gpuscene::Items: one of the casters
    bool alone = false;          ///< it is the only one: its map has its rotation, also where it drives
    bool ring = false;           ///< maps in equal steps, against which the casters are rotated; else each caster has its own yaw's map
    std::vector<double> angles;  ///< by map: radians about the vertical. A ring's count against the light's heading
    int firstMap = 0;            ///< its maps are numbered from here on
    base::Box box;               ///< prototype space, padded by the kernel's reach
    float pad = 0;               ///< metres of it
};

}  // namespace dapple::shadow
