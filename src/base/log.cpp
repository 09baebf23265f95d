#include "base/log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace dapple::base {
namespace {

double nowSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string clockText(double seconds) {
    const int s = static_cast<int>(seconds + 0.5);
    return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60) : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

void logInfo(std::string_view line) { fmt::print(stderr, "{}\n", line); }
void logWarning(std::string_view line) { fmt::print(stderr, "dapple: warning: {}\n", line); }

Progress::Progress(std::string title, size_t total)
    : title_(std::move(title)), total_(std::max<size_t>(total, 1)), terminal_(isatty(STDERR_FILENO) != 0),
      startSeconds_(nowSeconds()), lastSeconds_(startSeconds_) {}

Progress::~Progress() {
    if (drawn_ && terminal_) fmt::print(stderr, "\r\x1b[K");
}

void Progress::update(size_t done, std::string_view detail) {
    const double now = nowSeconds();
    const double elapsed = now - startSeconds_;
    if (elapsed < 2 || now - lastSeconds_ < (terminal_ ? 0.1 : 30.0)) return;
    lastSeconds_ = now;
    drawn_ = true;
    const double share = static_cast<double>(done) / static_cast<double>(total_);
    const std::string left = done > 0 ? clockText(elapsed / share - elapsed) : std::string("?");
    if (terminal_) {
        const auto filled = static_cast<size_t>(share * 24);
        fmt::print(stderr, "\r\x1b[K{} [{}{}] {}/{}  {} elapsed, {} left  {}", title_, std::string(filled, '#'),
                   std::string(24 - filled, '.'), done, total_, clockText(elapsed), left, detail);
    } else {
        fmt::print(stderr, "{}: {}/{}, {} elapsed, {} left {}\n", title_, done, total_, clockText(elapsed), left, detail);
    }
    std::fflush(stderr);
}

}  // namespace dapple::base
