#pragma once

#include "bench/sweep.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <string>
#include <vector>

namespace dapple::bench {

/// The arguments that `plan` and `run` share: which sweep, and what of it.
struct SweepOptions {
    std::string sweep;
    std::vector<std::string> overrides;
    std::vector<std::string> filters;

    void addTo(CLI::App& verb);
    Sweep read() const;  ///< throws UsageError
};

}  // namespace dapple::bench
