#include "base/log.h"

#include "base/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace dapple::base {
namespace {

double nowSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string clockText(double seconds) {
    const int s = static_cast<int>(seconds + 0.5);
    return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60) : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Bytes of the UTF-8 character at the front of `text`; 0 if there is none. (RFC 3629.)
size_t characterLength(std::string_view text) {
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
    const size_t length = byte(0) < 0x80 ? 1 : byte(0) < 0xc2 ? 0 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3 : byte(0) < 0xf5 ? 4 : 0;
    if (length > text.size()) return 0;
    for (size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xc0) != 0x80) return 0;
    const bool tooLong = (byte(0) == 0xe0 && byte(1) < 0xa0) || (byte(0) == 0xf0 && byte(1) < 0x90);
    const bool notACharacter = (byte(0) == 0xed && byte(1) > 0x9f) || (byte(0) == 0xf4 && byte(1) > 0x8f);
    return tooLong || notACharacter ? 0 : length;
}

/// When the last line of any job was written where there is no terminal: a job within another must not double the
/// lines.
double lastPlainLine = -1e9;

/// A terminal that cannot go back on its line is written to like a file.
std::optional<size_t> redrawnColumns() {
    const char* kind = std::getenv("TERM");
    return kind && std::string_view(kind) == "dumb" ? std::nullopt : terminalColumns(STDERR_FILENO);
}

}  // namespace

std::string printable(std::string_view text) {
    std::string shown;
    while (!text.empty()) {
        const size_t length = characterLength(text), taken = std::max<size_t>(length, 1);
        const auto first = static_cast<unsigned char>(text[0]);
        // U+0080 … U+009F are control characters of two bytes.
        const bool control = first < 0x20 || first == 0x7f || (first == 0xc2 && length == 2 && static_cast<unsigned char>(text[1]) < 0xa0);
        if (length > 0 && !control) shown += text.substr(0, taken);
        else
            for (const char c : text.substr(0, taken)) shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
        text.remove_prefix(taken);
    }
    return shown;
}

void logInfo(std::string_view line) { fmt::print(stderr, "{}\n", printable(line)); }
void logWarning(std::string_view line) { fmt::print(stderr, "dapple: warning: {}\n", printable(line)); }

Progress::Progress(std::string title, size_t total)
    : title_(std::move(title)),
      total_(std::max<size_t>(total, 1)),
      startSeconds_(nowSeconds()),
      lastSeconds_(startSeconds_) {}

Progress::~Progress() {
    if (drawn_ && redrawnColumns()) fmt::print(stderr, "\r\x1b[K");
}

void Progress::update(size_t done, std::string_view detail) {
    const double now = nowSeconds(), elapsed = now - startSeconds_;
    const std::optional<size_t> columns = redrawnColumns();
    const bool due = columns ? elapsed >= 2 && now - lastSeconds_ >= 0.1 : now - lastPlainLine >= 30;
    if (!due) return;
    (columns ? lastSeconds_ : lastPlainLine) = now;
    drawn_ = true;
    const double share = static_cast<double>(done) / static_cast<double>(total_);
    const std::string left = done > 0 ? clockText(elapsed / share - elapsed) : std::string("?");
    const std::string count = fmt::format("{}/{}", done, total_);
    if (columns) {
        constexpr size_t kBar = 24;
        const auto filled = static_cast<size_t>(std::clamp(share, 0.0, 1.0) * kBar);
        const std::string bar =
            *columns >= 72 ? fmt::format(" [{}{}]", std::string(filled, '#'), std::string(kBar - filled, '.')) : "";
        const std::string line =
            fmt::format("{}{} {}  {}, {} left  {}", title_, bar, count, clockText(elapsed), left, detail);
        fmt::print(stderr, "\r\x1b[K{}", shortened(line, *columns - 1));  // the last column would start a new line
    } else {
        fmt::print(stderr, "{}: {}, {} elapsed, {} left  {}\n", title_, count, clockText(elapsed), left, detail);
    }
    std::fflush(stderr);
}

}  // namespace dapple::base
