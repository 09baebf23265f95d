#pragma once

#include "frame/frame.h"
#include "gpuscene/items.h"

#include <vector>

namespace dapple::shadow {

/// Casters whose shadows can reach a receiver in the frame's present view, sorted. `stray`: metres by which a shadow may leave
/// its volume.
std::vector<uint32_t> castersInReach(const frame::Frame& frame, const gpuscene::Items& items, double stray);

}  // namespace dapple::shadow
