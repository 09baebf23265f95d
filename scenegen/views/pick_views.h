#pragma once

#include "scenegen/scene.h"

#include <vector>

namespace dapple::scenegen {

/// The `count` of `candidates` that show most (Sight::score) and stand well apart, best first. Views that show nothing are left
/// out, so fewer may come back.
std::vector<View> pickViews(const Scene& scene, const std::vector<View>& candidates, size_t count);

}  // namespace dapple::scenegen
