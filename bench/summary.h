#pragma once

#include "bench/run.h"
#include "bench/workbench.h"

#include <string>

namespace dapple::bench {

/// Ends a run: draws the plots and, per scene and view, pictures of the points on the front; prints where they are and a table of
/// those points. Throws as requireClean(), and Error (exit 2 or 4) if the plot cannot be drawn; all else is done by then.
void summarise(const std::string& folder, const Sweep& sweep, const Plan& plan, Workbench& workbench, const RunOutcome& outcome, bool plot = true);

/// Removes what summarise() wrote.
void removeSummary(const std::string& folder);

}  // namespace dapple::bench
