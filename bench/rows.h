#pragma once

#include "bench/plan.h"
#include "measure/counters.h"
#include "measure/sampler.h"

#include <array>
#include <span>
#include <string>
#include <vector>

/// The rows of metrics.csv and samples.csv. results/SCHEMA.md says what each column means.
namespace dapple::bench {

inline constexpr const char* kSchema = "2.0";

inline const std::array<std::string, 21> kMetricsColumns{
    "schema", "run_id", "point_id", "scene", "technique", "view", "pass", "metric", "unit", "better", "n",
    "median", "ci_lo", "ci_hi", "q1", "q3", "min", "max", "backend", "status", "flags"};
inline const std::array<std::string, 11> kSamplesColumns{"run_id", "point_id", "process", "block", "order", "arm",
                                                         "frame",  "pass",     "metric",  "value", "flags"};

/// Metrics that the run itself adds to measure::metrics(): ratios of frame times, and rows that state a fact.
std::span<const measure::MetricInfo> runMetrics();

/// `text` with blanks for line breaks and tabs: a reason may quote a shader compiler.
std::string oneLine(std::string text);

/// What was found out about one point besides times.
struct PointFindings {
    std::vector<Figure> figures;
    std::vector<PassNote> leftOut;
    std::string fallback;
    std::string failure;  ///< not empty: the point failed, and nothing else about it is written
};

struct RowContext {
    std::string runId, backend;
    int process = 0;
    bool timerRejected = false;  ///< every row that holds a value says so
};

/// Text of one comparison's rows. All vectors are parallel to comparison.points; `arms` holds nothing
/// for points that failed before they were sampled.
struct ComparisonRows {
    std::string metrics, samples;
};
ComparisonRows comparisonRows(const Plan& plan, const Comparison& comparison, const std::vector<PointFindings>& findings,
                              const std::vector<std::optional<measure::ArmResult>>& arms, const RowContext& context);

}  // namespace dapple::bench
