#pragma once

#include "bench/plan.h"

#include <string>
#include <vector>

namespace dapple::bench {

/// Renders the shaded picture and the error image of each planned point into `folder`, which is made, and returns the
/// files' paths. A name says scene, view, technique, variant and the settings in which the plan's points differ, and
/// ends with the point's id, so that no two points share a file. Throws UsageError if they cannot be written.
std::vector<std::string> renderPictures(const std::string& folder, Workbench& workbench, const Plan& plan,
                                        const std::vector<PlannedPoint>& points);

}  // namespace dapple::bench
