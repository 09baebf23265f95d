#pragma once

#include <string>
#include <vector>

namespace dapple::bench {

/// Rows as lines of aligned columns, two spaces apart; the last column is not padded. Widths count UTF-8
/// characters. Rows may be shorter than others.
std::string alignColumns(const std::vector<std::vector<std::string>>& rows);

}  // namespace dapple::bench
