#pragma once

#include "bench/sweep.h"
#include "bench/workbench.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace re2 { class RE2; }

/// The plan: every point of a sweep, in the order in which its rows stand in the files of a run.
namespace dapple::bench {

struct PlannedPoint {
    std::string id;  ///< 16 hex digits: canonical axes, technique's version, scene's content, view, resolution, the sun's path
    PointSpec spec;
    std::string prunedBecause;  ///< empty: the point runs
};

/// Points that are sampled together: same scene, variant, stiff case and view; only so are their times comparable.
struct Comparison {
    std::vector<size_t> points;  ///< indices of planned points
};

struct Plan {
    std::string sweepName;
    measure::SamplingPlan sampling;
    std::vector<PlannedPoint> points;
    std::map<std::string, std::string> sceneHashes;  ///< "scene[variant]/stress", without what is empty → 16 hex digits
    PlotRequest plot;
    std::optional<MotionPath> path = {};

    std::vector<Comparison> comparisons() const;
    /// The settings in which points of the same technique differ: "filter=pcf3 size=1024".
    std::string differing(const PointSpec& spec) const;
    std::string csv() const;   ///< text of plan.csv
    uint64_t hash() const;     ///< of the plan and of how it is sampled
};

/// Which points a person wants: every pattern must be found (regular expression of RE2, case ignored) in
/// "scene technique axis=value … view stress variant". Time and memory are bounded whatever the pattern.
class PointFilter {
public:
    PointFilter() = default;
    /// Throws UsageError for a malformed or too large pattern.
    explicit PointFilter(const std::vector<std::string>& patterns);
    bool accepts(const PointSpec& spec) const;

private:
    std::vector<std::shared_ptr<const re2::RE2>> patterns_;
};

std::string pointId(const PointSpec& spec, uint64_t sceneHash);

/// "uniform size=1024 filter=pcf3"
std::string pointText(const PointSpec& spec);

/// Throws UsageError: unknown scene or view, a sun's path that meets the horizon or the zenith, or nothing is left after the filter.
Plan makePlan(const Sweep& sweep, Workbench& workbench, const PointFilter& filter = {});

}  // namespace dapple::bench
