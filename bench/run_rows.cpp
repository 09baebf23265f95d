#include "bench/run_rows.h"

#include "base/error.h"
#include "base/file.h"
#include "bench/csv.h"

#include <fmt/format.h>

#include <vector>

namespace dapple::bench {
namespace {

size_t comparisonAt(const CsvTable& table, size_t row, const std::filesystem::path& csv, const std::map<std::string, size_t>& comparisonOf) {
    const auto found = comparisonOf.find(table.at(row, "point_id"));
    if (found == comparisonOf.end())
        throw base::Error(base::ExitCode::corrupt, fmt::format("{} has point {}, which is not in the plan; remove the folder and run again",
                                                               csv.string(), table.at(row, "point_id")));
    return found->second;
}

}  // namespace

std::map<size_t, std::string> rowsByComparison(const std::filesystem::path& csv, const std::map<std::string, size_t>& comparisonOf,
                                               const std::string& flag) {
    const CsvTable table(base::readFile(csv), csv.string());
    std::map<size_t, std::string> rows;
    for (size_t row = 0; row < table.rows(); ++row) {
        std::vector<std::string> fields;
        for (const std::string& column : table.header()) {
            fields.push_back(table.at(row, column));
            if (column == "flags" && !flag.empty()) fields.back() += (fields.back().empty() ? "" : ";") + flag;
        }
        rows[comparisonAt(table, row, csv, comparisonOf)] += csvRow(fields);
    }
    return rows;
}

std::set<size_t> failedComparisons(const std::filesystem::path& metricsCsv, const std::map<std::string, size_t>& comparisonOf) {
    const CsvTable table(base::readFile(metricsCsv), metricsCsv.string());
    std::set<size_t> failed;
    for (size_t row = 0; row < table.rows(); ++row)
        if (const std::string& status = table.at(row, "status"); status == "failed" || status == "invalid")
            failed.insert(comparisonAt(table, row, metricsCsv, comparisonOf));
    return failed;
}

}  // namespace dapple::bench
