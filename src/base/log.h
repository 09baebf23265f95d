#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dapple::base {

/// Names come from files that nobody here wrote. Control characters, and bytes that are not UTF-8, become \xNN, so that a
/// terminal shows them and does not obey.
std::string printable(std::string_view text);

/// Everything a person reads while the program runs goes to stderr; stdout carries data only. Nothing is coloured.
/// Lines are made printable().
void logInfo(std::string_view line);
void logWarning(std::string_view line);

/// Progress of one long job. On a terminal: a bar with an estimate of the time left, redrawn on one line that fits its
/// width, silent until the job has taken two seconds. Elsewhere: a plain line at once, then one every 30 s, however
/// many jobs there are.
class Progress {
public:
    /// `total` steps of `what` ("points", "instances").
    Progress(std::string title, size_t total);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    /// `done` steps are finished; `detail` names the one under way.
    void update(size_t done, std::string_view detail = {});

private:
    std::string title_;
    size_t total_;
    bool drawn_ = false;
    double startSeconds_;
    double lastSeconds_;
};

}  // namespace dapple::base
