#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace dapple::base {

/// Process exit codes. They are part of the command line's contract: scripts branch on them.
enum class ExitCode : int {
    ok = 0,
    regression = 1,
    usage = 2,         ///< wrong arguments, configuration or input; no GL context
    incomparable = 3,  ///< missing or extra points
    corrupt = 4,       ///< damaged results or a failed merge
    failed = 5,        ///< a measurement failed or is invalid
    undecided = 6,
    interrupted = 130,
};

/// An error that a person can act on. what() is one line: what is wrong, where, what to do.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const std::string& line) : std::runtime_error(line), code_(code) {}
    ExitCode code() const { return code_; }

private:
    ExitCode code_;
};

/// Bad input or environment: exit code 2.
class UsageError : public Error {
public:
    explicit UsageError(const std::string& line) : Error(ExitCode::usage, line) {}
};

/// The known name nearest to `name` by edit distance; empty if none is near enough to be meant.
std::string nearestName(std::string_view name, std::span<const std::string> known);

/// "unknown technique 'unifrom'; did you mean 'uniform'? (known: uniform, focused, …)"
std::string unknownName(std::string_view kind, std::string_view name, std::span<const std::string> known);

}  // namespace dapple::base
