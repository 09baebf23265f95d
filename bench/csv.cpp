#include "bench/csv.h"

#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dapple::bench {
namespace {

[[noreturn]] void corrupt(const std::string& source, size_t line, std::string_view why) {
    throw base::Error(base::ExitCode::corrupt, fmt::format("{}:{}: {}; run the sweep again", source, line, why));
}

/// The fields of the row at `at`, which is moved behind the row's line end. `line` counts lines.
std::vector<std::string> readRow(std::string_view text, size_t& at, size_t& line, const std::string& source) {
    std::vector<std::string> fields(1);
    const size_t firstLine = line;
    bool quoted = false;
    for (; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '\n') ++line;
        if (quoted) {
            if (c != '"') fields.back() += c;
            else if (at + 1 < text.size() && text[at + 1] == '"') fields.back() += text[++at];
            else quoted = false;
        } else if (c == '"' && fields.back().empty()) {
            quoted = true;
        } else if (c == ',') {
            fields.emplace_back();
        } else if (c == '\n') {
            ++at;
            return fields;
        } else if (c != '\r') {
            fields.back() += c;
        }
    }
    corrupt(source, firstLine, quoted ? "a quote is never closed" : "the last line is cut off");
}

}  // namespace

std::string csvRow(std::span<const std::string> fields) {
    std::string row;
    for (size_t i = 0; i < fields.size(); ++i) {
        if (i > 0) row += ',';
        if (fields[i].find_first_of(",\"\r\n") == std::string::npos) {
            row += fields[i];
            continue;
        }
        row += '"';
        for (const char c : fields[i]) {
            if (c == '"') row += '"';
            row += c;
        }
        row += '"';
    }
    row += '\n';
    return row;
}

std::string csvNumber(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string{}; }

CsvTable::CsvTable(std::string_view text, const std::string& source) : source_(source) {
    size_t at = 0, line = 1;
    if (text.empty()) corrupt(source, 1, "the file is empty");
    header_ = readRow(text, at, line, source);
    while (at < text.size()) {
        const size_t rowLine = line;
        cells_.push_back(readRow(text, at, line, source));
        if (cells_.back().size() != header_.size())
            corrupt(source, rowLine, fmt::format("{} fields, but the header names {}", cells_.back().size(), header_.size()));
    }
}

const std::string& CsvTable::at(size_t row, std::string_view column) const {
    const auto found = std::find(header_.begin(), header_.end(), column);
    if (found == header_.end()) corrupt(source_, 1, fmt::format("there is no column '{}'", column));
    return cells_[row][static_cast<size_t>(found - header_.begin())];
}

}  // namespace dapple::bench
