#include "base/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

namespace dapple::base {
namespace {

constexpr size_t kUsualColumns = 80;

bool beginsCharacter(char c) { return (c & 0xc0) != 0x80; }

/// One line of wrapWords(). Blanks before its first word stay.
std::string wrapLine(std::string_view line, size_t columns, std::string_view indent, std::string_view joint) {
    std::string out, row;
    for (size_t at = 0; at < line.size();) {
        const size_t word = std::min(line.find_first_not_of(' ', at), line.size());
        const size_t end = std::min(line.find(' ', word), line.size());
        const size_t room = columns - std::min(columns, end == line.size() ? 0 : textWidth(joint));
        if (at > 0 && textWidth(row) + textWidth(line.substr(at, end - at)) > room) {
            out += row + std::string(joint) + "\n";
            row = std::string(indent) + std::string(line.substr(word, end - word));
        } else {
            row += line.substr(at, end - at);
        }
        at = end;
    }
    return out + row;
}

}  // namespace

std::optional<size_t> terminalColumns(int fd) {
    if (isatty(fd) == 0) return {};
    winsize size{};
    // A serial line does not know its size.
    return ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsualColumns;
}

size_t textWidth(std::string_view text) {
    return static_cast<size_t>(std::count_if(text.begin(), text.end(), beginsCharacter));
}

std::string shortened(std::string_view text, size_t columns) {
    if (textWidth(text) <= columns) return std::string(text);
    if (columns == 0) return "";
    size_t end = 0;
    for (size_t characters = 0; end < text.size(); ++end)
        if (beginsCharacter(text[end]) && ++characters == columns) break;
    return std::string(text.substr(0, end)) + "…";
}

std::string wrapWords(std::string_view text, size_t columns, std::string_view indent, std::string_view joint) {
    std::string out;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        out += wrapLine(text.substr(begin, end - begin), columns, indent, joint);
        if (end < text.size()) out += '\n';
        begin = end + 1;
    }
    return out;
}

}  // namespace dapple::base
