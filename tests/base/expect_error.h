#pragma once

#include "base/error.h"

#include <gtest/gtest.h>

#include <string>

namespace dapple::base {

/// The message of the Error that `action` throws; a test failure and "" if it throws none, or another
/// code, or more than one line.
template <class F>
std::string errorLine(const F& action, ExitCode code = ExitCode::usage) {
    try {
        action();
    } catch (const Error& e) {
        const std::string line = e.what();
        EXPECT_EQ(int(e.code()), int(code)) << line;
        EXPECT_EQ(line.find('\n'), std::string::npos) << line;
        return line;
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
}

inline void expectHolds(const std::string& line, const std::string& part) {
    EXPECT_NE(line.find(part), std::string::npos) << "'" << part << "' is not in: " << line;
}

}  // namespace dapple::base
