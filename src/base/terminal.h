#pragma once

#include <optional>
#include <string>
#include <string_view>

/// What fits on a line. Widths count UTF-8 characters.
namespace dapple::base {

/// Columns of the terminal behind a file descriptor; nothing where it is no terminal.
std::optional<size_t> terminalColumns(int fd);

size_t textWidth(std::string_view text);

/// The text, or its beginning and "…" where it has more than `columns` characters.
std::string shortened(std::string_view text, size_t columns);

/// The text's lines, broken between words so that each has at most `columns` characters. A broken line goes on below
/// `indent`, and its parts end with `joint`. A word that is longer than a line keeps its length.
std::string wrapWords(std::string_view text, size_t columns, std::string_view indent = "", std::string_view joint = "");

}  // namespace dapple::base
