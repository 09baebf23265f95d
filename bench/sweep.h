#pragma once

#include "bench/motion_path.h"
#include "measure/sampler.h"
#include "shadow/registry.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// A sweep is data: which scenes, views and techniques, over which axes, and how long to sample.
/// CONTRIBUTING.md and `dapple run --help` show the format; bench/sweeps holds the named ones.
namespace dapple::bench {

/// Axes of one [[technique]] table: the product of their values; the zipped ones advance together.
struct TechniqueEntry {
    std::string technique;
    std::vector<std::pair<std::string, std::vector<std::string>>> axes;  ///< canonical values, in the registry's order
    std::vector<std::string> zip;                                       ///< names of axes of equal length
};

/// What the figure of a sweep shows, where that is not error against frame time.
struct PlotRequest {
    std::string x;        ///< an axis, or "variant"; empty: error against frame time
    std::string y;        ///< a metric of whole frames (measure::metrics())
    std::string columns;  ///< an axis with a column of panels for each value; empty: one column
};

struct Sweep {
    std::string name;      ///< stem of the file
    std::string question;  ///< what the sweep is to answer
    std::vector<std::string> scenes;
    std::vector<std::string> sceneSettings;  ///< key=value overrides of every scene's recipe
    std::vector<std::string> variants;       ///< of every scene: "key=value; key=value", "" as the recipe is; empty: only that
    std::vector<std::string> views;          ///< empty: the first view of each scene
    std::vector<std::string> stress;         ///< stiff cases (stress.h); empty: scenes as they are
    int width = 1024, height = 768;          ///< pixels
    measure::SamplingPlan sampling;          ///< how times are taken, the same for every point
    std::optional<MotionPath> path;          ///< [motion]; empty: all stand still
    std::vector<TechniqueEntry> entries;
    PlotRequest plot;
};

struct SweepFile {
    std::string name;
    std::filesystem::path path;
};
/// The sweeps in bench/sweeps, sorted by name.
std::vector<SweepFile> listSweeps();

/// `nameOrPath`: the name of a sweep in bench/sweeps, or a file; ./NAME is a file whatever its name. Throws UsageError
/// of one line: no such sweep (with the nearest), or file, line and the rule that the file breaks.
Sweep readSweep(const std::string& nameOrPath);
Sweep parseSweep(const std::string& toml, const std::string& fileName);

/// The settings that a variant "key=value; key=value" names.
std::vector<std::string> variantSettings(const std::string& variant);

/// Replaces the values of one axis, "size=512,1024", in every technique of the sweep that has it.
/// Throws UsageError: malformed, unknown axis or value, or no technique of the sweep has the axis.
void overrideAxis(Sweep& sweep, const std::string& assignment);

/// Every product of the entry's axes, the last axis fastest; axes that are not named keep their defaults.
std::vector<shadow::Settings> expand(const TechniqueEntry& entry);

}  // namespace dapple::bench
