#pragma once

#include "bench/workbench.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <string>
#include <vector>

namespace dapple::bench {

/// The arguments that `render` and `view` share: one point.
struct PointOptions {
    std::string scene, technique, view, stress, resolution = "1024x768";
    std::vector<std::string> axes, settings;

    /// Scene and technique are required where they are empty.
    void addTo(CLI::App& verb);
    /// Throws UsageError: unknown technique, axis, value or stiff case, or a malformed resolution. The view is as it
    /// was given: empty for the scene's first.
    PointSpec spec() const;
    shadow::Settings overrides() const;  ///< what -a asks for; throws UsageError for a malformed one
};

}  // namespace dapple::bench
