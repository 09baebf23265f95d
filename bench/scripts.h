#pragma once

#include <string>
#include <vector>

namespace dapple::bench {

/// Draws the figures of the run in `folder` with bench/report/plot.py, which gets `options` too. Throws UsageError if the folder holds
/// no run; Error (exit 2 or 4) if the script fails, which has then said why.
void plotRun(const std::string& folder, const std::vector<std::string>& options = {});

/// Downloads those of `scenes` that are real scenes and not in the cache, each with its script. Throws as plotRun().
void fetchRealScenes(const std::vector<std::string>& scenes);

/// Writes the relocatable archive with bench/bundle.sh. Throws as plotRun().
void writeBundle(const std::string& file);

}  // namespace dapple::bench
