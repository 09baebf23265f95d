#pragma once

#include "bench/run.h"
#include "bench/workbench.h"

#include <string>

namespace dapple::bench {

/// Ends a run: draws the plots and, per scene, pictures of the best points; prints where they are and a table of
/// those points. A plot that cannot be drawn (no Python on a node) is a warning: the measurements are safe.
/// Throws as requireClean().
void summarise(const std::string& folder, const Sweep& sweep, const Plan& plan, Workbench& workbench, const RunOutcome& outcome);

/// Removes what summarise() wrote.
void removeSummary(const std::string& folder);

}  // namespace dapple::bench
