#pragma once

#include <string>
#include <vector>

namespace dapple::bench {

/// Runs a program found by `args[0]` (searched in PATH) and waits for it. Its exit status; 127 if it cannot be
/// started, 128 + n if signal n ended it. With `output`, its stdout is caught there and its stderr dropped.
int runProgram(const std::vector<std::string>& args, std::string* output = nullptr);

}  // namespace dapple::bench
