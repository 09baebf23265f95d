#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>

/// Rows of metrics.csv and samples.csv, taken apart by comparison: what a resumed run needs to measure some again and to put
/// all into the plan's order.
namespace dapple::bench {

/// Text of the rows of each comparison, in the file's order. `comparisonOf`: comparison by point id. Not an empty `flag` is added to
/// the flags of every row. Throws Error (exit 4) for a damaged file or a point that is not in the plan.
std::map<size_t, std::string> rowsByComparison(const std::filesystem::path& csv, const std::map<std::string, size_t>& comparisonOf,
                                               const std::string& flag = {});

/// Comparisons with a row of metrics.csv whose status is `failed` or `invalid`.
std::set<size_t> failedComparisons(const std::filesystem::path& metricsCsv, const std::map<std::string, size_t>& comparisonOf);

}  // namespace dapple::bench
