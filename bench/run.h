#pragma once

#include "bench/plan.h"

#include <string>

namespace dapple::bench {

struct RunOptions {
    std::string folder = {};
    bool resume = false;
    bool mix = false;          ///< resume although the program or the machine is another; every row says so
    bool retryFailed = false;  ///< resume, and measure the comparisons again that hold failed or invalid rows
};

struct RunOutcome {
    size_t points = 0;   ///< that were to be measured
    size_t failed = 0;   ///< of these, points without measurements
    size_t invalid = 0;  ///< rows with status invalid
    bool clean() const { return failed == 0 && invalid == 0; }
};

/// Measures every planned point and writes plan.csv, metrics.csv, samples.csv and run.json as results/SCHEMA.md
/// says. The points of one comparison are open at once and sampled interleaved. A point that fails becomes a
/// row, and the run goes on. Throws Error: exit 130 after Ctrl-C or SIGTERM, with how to resume; UsageError
/// for a folder that cannot be written.
RunOutcome runPlan(const Plan& plan, Workbench& workbench, const RunOptions& options);

/// "3 of 15 points failed and 0 rows are invalid; see out/metrics.csv": throws it as exit 5 unless clean.
void requireClean(const RunOutcome& outcome, const std::string& folder);

}  // namespace dapple::bench
