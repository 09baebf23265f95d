#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace dapple::measure {

/// Validity flags. A flagged row stays in the file; a value flagged as invalid is left out of summaries.
namespace flag {
inline constexpr std::string_view kWrap = "wrap";
inline constexpr std::string_view kLost = "lost";
inline constexpr std::string_view kThrottled = "throttled";
inline constexpr std::string_view kNoisy = "noisy";
inline constexpr std::string_view kTimeout = "timeout";
inline constexpr std::string_view kNonfinite = "nonfinite";
inline constexpr std::string_view kOom = "oom";
inline constexpr std::string_view kGlError = "gl_error";
inline constexpr std::string_view kTimerGtWall = "timer_gt_wall";
inline constexpr std::string_view kPassesGtFrame = "passes_gt_frame";
inline constexpr std::string_view kMixed = "mixed";
inline constexpr std::string_view kTimerRejected = "timer_rejected";
inline constexpr std::string_view kOutlier = "outlier";
inline constexpr std::string_view kFarOutlier = "far_outlier";
}  // namespace flag

struct FlagInfo {
    std::string_view name;
    bool invalidatesSample;  ///< a sample so flagged is no time at all and enters no summary
    std::string_view description;
};

inline constexpr std::array kFlags{
    FlagInfo{flag::kWrap, true, "the GPU's counter wrapped between begin and end"},
    FlagInfo{flag::kLost, true, "the result of a timer query never arrived"},
    FlagInfo{flag::kThrottled, false, "the machine slowed down: all arms' block times rose together by more than 5 %"},
    FlagInfo{flag::kNoisy, false, "the confidence interval of the median is wider than the plan's target"},
    FlagInfo{flag::kTimeout, false, "sampling was ended by its time limit"},
    FlagInfo{flag::kNonfinite, true, "the value is not a finite number >= 0"},
    FlagInfo{flag::kOom, true, "the GPU ran out of memory"},
    FlagInfo{flag::kGlError, true, "GL raised an error during the frame"},
    FlagInfo{flag::kTimerGtWall, false, "the timer reports more time than passed on the wall clock"},
    FlagInfo{flag::kPassesGtFrame, false, "the passes, timed one by one, sum to more than the whole frame"},
    FlagInfo{flag::kMixed, false, "the run was resumed with another program or on another machine (--mix)"},
    FlagInfo{flag::kTimerRejected, false, "the self-test rejected the timer that --backend forced: its times may be wrong by any factor"},
    FlagInfo{flag::kOutlier, false, "beyond 1.5 interquartile ranges from the quartiles (Tukey 1977)"},
    FlagInfo{flag::kFarOutlier, false, "beyond 3 interquartile ranges from the quartiles (Tukey 1977)"},
};

using Flags = std::vector<std::string>;  ///< no duplicates, in the order in which they were raised

inline bool hasFlag(const Flags& flags, std::string_view name) {
    return std::find(flags.begin(), flags.end(), name) != flags.end();
}

inline void addFlag(Flags& flags, std::string_view name) {
    if (!hasFlag(flags, name)) flags.emplace_back(name);
}

/// True if none of the flags makes the sample's value meaningless.
inline bool isValidSample(const Flags& flags) {
    return std::none_of(kFlags.begin(), kFlags.end(),
                        [&](const FlagInfo& info) { return info.invalidatesSample && hasFlag(flags, info.name); });
}

/// "lost;noisy": the form of the flags column. Empty when there are none.
inline std::string joinFlags(const Flags& flags) {
    std::string joined;
    for (const auto& name : flags) joined += (joined.empty() ? "" : ";") + name;
    return joined;
}

/// A device time cannot exceed the wall time that encloses it, except by the disagreement of the two clocks:
/// 2 % of rate (crystals agree far better; virtualised clocks do not) and 0.05 ms of reading them.
inline bool exceedsWall(double timerMs, double wallMs) { return timerMs > 1.02 * wallMs + 0.05; }

}  // namespace dapple::measure
