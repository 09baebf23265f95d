#pragma once

#include "bench/workbench.h"

#include <string>
#include <vector>

namespace dapple::bench {

/// Renders the shaded picture and the error image of each point into `folder`, which is made, and returns the
/// files' paths. Throws UsageError if they cannot be written.
std::vector<std::string> renderPictures(const std::string& folder, Workbench& workbench, const std::vector<PointSpec>& points);

}  // namespace dapple::bench
