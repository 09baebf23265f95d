#pragma once

#include <span>
#include <string>
#include <string_view>

namespace dapple::measure {

/// Names of metrics that code refers to; all others are only in the table.
namespace metric {
inline constexpr std::string_view kFrameTime = "frame_time";
inline constexpr std::string_view kPassTime = "pass_time";
inline constexpr std::string_view kFirstFrame = "first_frame";
inline constexpr std::string_view kSamplesPassed = "samples_passed";
inline constexpr std::string_view kFragmentInvocations = "fragment_invocations";
inline constexpr std::string_view kVertexInvocations = "vertex_invocations";
inline constexpr std::string_view kPrimitivesSubmitted = "primitives_submitted";
}  // namespace metric

/// The `better` column of metrics.csv; `none`: a fact, of which neither more nor less is good.
enum class Better { lower, higher, none };
std::string_view betterName(Better better);

struct MetricInfo {
    std::string_view name;  ///< as in the `metric` column
    std::string_view unit;  ///< empty: a ratio or a share of 1
    Better better;
    bool deterministic;     ///< equal on every run on the same machine and driver: compared for equality
    std::string_view description;
};

/// Every metric that a run can write, in the order of `dapple list metrics`.
std::span<const MetricInfo> metrics();

/// By name; throws UsageError with the nearest known name.
const MetricInfo& metricInfo(std::string_view name);

}  // namespace dapple::measure
