#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Comma-separated values as RFC 4180 quotes them, with "\n" line ends.
namespace dapple::bench {

/// One row with its line end. A field is quoted only if it holds a comma, a quote or a line break.
std::string csvRow(std::span<const std::string> fields);

/// Shortest text that reads back as the same double; empty (missing) if the value is not finite.
std::string csvNumber(double value);

/// A table whose first row names the columns. Read by name: columns may be added or reordered later.
class CsvTable {
public:
    /// Throws Error (exit 4) naming `source` and the line: a ragged row, an unclosed quote, no header.
    CsvTable(std::string_view text, const std::string& source);

    size_t rows() const { return cells_.size(); }
    const std::vector<std::string>& header() const { return header_; }
    /// Throws Error (exit 4) if there is no such column.
    const std::string& at(size_t row, std::string_view column) const;

private:
    std::string source_;
    std::vector<std::string> header_;
    std::vector<std::vector<std::string>> cells_;
};

}  // namespace dapple::bench
