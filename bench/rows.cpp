#include "bench/rows.h"

#include "bench/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dapple::bench {
namespace {

constexpr const char* kToUnshadowed = "to_unshadowed";
constexpr const char* kToBare = "to_bare";
constexpr const char* kLeftOut = "left_out";
constexpr const char* kFallback = "fallback";
constexpr const char* kFailed = "failed";

/// Columns behind `better` of one row.
struct Values {
    std::string n, median, ciLo, ciHi, q1, q3, min, max, status, flags;
};

std::string joined(const std::string& flags, std::string_view flag) { return flags + (flags.empty() ? "" : ";") + std::string(flag); }

class PointRows {
public:
    PointRows(const PlannedPoint& point, const RowContext& context) : point_(point), context_(context) {}

    void add(const std::string& pass, std::string_view metric, const std::string& unit, const std::string& better, Values v) {
        const PointSpec& s = point_.spec;
        if (context_.timerRejected && (v.status == "ok" || v.status == "invalid")) v.flags = joined(v.flags, measure::flag::kTimerRejected);
        text += csvRow(std::array<std::string, 21>{kSchema, context_.runId, point_.id, s.scene, s.technique, s.view, pass, std::string(metric), unit,
                                                   better, v.n, v.median, v.ciLo, v.ciHi, v.q1, v.q3, v.min, v.max, context_.backend,
                                                   v.status, v.flags});
    }
    void note(const std::string& pass, const std::string& metric, const std::string& reason) {
        add(pass, metric, "", "", {.n = "", .median = "", .ciLo = "", .ciHi = "", .q1 = "", .q3 = "", .min = "", .max = "",
                                   .status = metric, .flags = oneLine(reason)});
    }
    void figure(const Figure& f) {
        Values v;
        v.flags = f.flags;
        if (f.value && std::isfinite(*f.value)) {
            v.n = f.spread ? fmt::format("{}", f.spread->n) : "1";
            v.median = csvNumber(*f.value);
            if (f.spread) {
                v.q1 = csvNumber(f.spread->q1);
                v.q3 = csvNumber(f.spread->q3);
                v.min = csvNumber(f.spread->min);
                v.max = csvNumber(f.spread->max);
            }
        } else if (f.value) {
            v.flags = joined(v.flags, measure::flag::kNonfinite);
        }
        const bool invalid = std::any_of(measure::kFlags.begin(), measure::kFlags.end(), [&](const measure::FlagInfo& info) {
            return info.invalidatesSample && (";" + v.flags + ";").find(";" + std::string(info.name) + ";") != std::string::npos;
        });
        v.status = invalid ? "invalid" : f.value ? "ok" : "missing";
        add(f.pass, f.metric, f.unit, f.better, v);
    }
    void times(const std::string& pass, std::string_view metric, const measure::Summary& s, const measure::Flags& flags) {
        Values v;
        v.status = s.n == 0 || !measure::isValidSample(flags) ? "invalid" : "ok";
        v.flags = measure::joinFlags(flags);
        v.n = fmt::format("{}", s.n);
        if (s.n > 0) {
            v.median = csvNumber(s.median);
            if (s.ci) {
                v.ciLo = csvNumber(s.ci->lo);
                v.ciHi = csvNumber(s.ci->hi);
            }
            v.q1 = csvNumber(s.q1);
            v.q3 = csvNumber(s.q3);
            v.min = csvNumber(s.min);
            v.max = csvNumber(s.max);
        }
        add(pass, metric, "ms", "lower", v);
    }
    void ratio(const std::string& metric, const std::optional<measure::Ratio>& ratio) {
        Values v;
        v.status = ratio ? "ok" : "missing";
        if (ratio) {
            v.n = fmt::format("{}", ratio->n);
            v.median = csvNumber(ratio->value);
            v.ciLo = csvNumber(ratio->ci.lo);
            v.ciHi = csvNumber(ratio->ci.hi);
        }
        add("", metric, "", "lower", v);
    }

    std::string text;

private:
    const PlannedPoint& point_;
    const RowContext& context_;
};

/// How far frames of a path are from even: a technique that asks and waits has spikes that a median hides.
void addSpikes(PointRows& row, const measure::ArmResult& arm) {
    std::vector<double> ms;
    for (const measure::Sample& s : arm.samples)
        if (s.pass < 0 && s.ms) ms.push_back(*s.ms);
    if (ms.empty()) return;
    std::sort(ms.begin(), ms.end());
    const double mean = std::accumulate(ms.begin(), ms.end(), 0.0) / double(ms.size());
    for (const auto& [metric, value] : {std::pair("frame_time_mean", mean), {"frame_time_p95", measure::quantileOfSorted(ms, 0.95)},
                                        {"frame_time_p99", measure::quantileOfSorted(ms, 0.99)}, {"frame_time_worst", ms.back()}})
        row.figure({"", metric, "ms", "lower", value, ""});
}

std::string sampleRows(const PlannedPoint& point, size_t armIndex, const measure::ArmResult& arm, const RowContext& context) {
    std::string text;
    for (const measure::Sample& s : arm.samples) {
        const bool whole = s.pass < 0;
        const std::string flags = measure::joinFlags(s.flags);
        text += csvRow(std::array<std::string, 11>{
            context.runId, point.id, fmt::format("{}", context.process), fmt::format("{}", s.block), fmt::format("{}", s.order),
            fmt::format("{}", armIndex), fmt::format("{}", s.frame), whole ? "" : arm.passes.at(static_cast<size_t>(s.pass)).name,
            std::string(whole ? measure::metric::kFrameTime : measure::metric::kPassTime), s.ms ? csvNumber(*s.ms) : "",
            context.timerRejected ? joined(flags, measure::flag::kTimerRejected) : flags});
    }
    return text;
}

}  // namespace

std::string oneLine(std::string text) {
    std::replace_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
    return text;
}

std::span<const measure::MetricInfo> runMetrics() {
    using enum measure::Better;
    static constexpr std::array kMetrics{
        measure::MetricInfo{kToUnshadowed, "", lower, false, "frame time / that of technique unshadowed, paired by round"},
        measure::MetricInfo{kToBare, "", lower, false, "frame time / that of technique bare, paired by round"},
        measure::MetricInfo{kLeftOut, "", none, true, "pass that the scene does not need; the reason is in flags"},
        measure::MetricInfo{kFallback, "", none, true, "the technique fell back to another; which and why is in flags"},
        measure::MetricInfo{kFailed, "", none, true, "the point could not be measured; the reason is in flags"},
    };
    return kMetrics;
}

ComparisonRows comparisonRows(const Plan& plan, const Comparison& comparison, const std::vector<PointFindings>& findings,
                              const std::vector<std::optional<measure::ArmResult>>& arms, const RowContext& context) {
    ComparisonRows rows;
    const auto baseline = [&](const char* technique) -> const measure::ArmResult* {
        for (size_t i = 0; i < arms.size(); ++i)
            if (arms[i] && findings[i].failure.empty() && plan.points[comparison.points[i]].spec.technique == technique) return &*arms[i];
        return nullptr;
    };
    const measure::ArmResult* unshadowed = baseline("unshadowed");
    const measure::ArmResult* bare = baseline("bare");
    for (size_t i = 0; i < comparison.points.size(); ++i) {
        const PlannedPoint& point = plan.points[comparison.points[i]];
        PointRows row(point, context);
        if (!findings[i].failure.empty()) {
            row.note("", kFailed, findings[i].failure);
            rows.metrics += row.text;
            continue;
        }
        const measure::ArmResult& arm = arms[i].value();
        row.times("", measure::metric::kFrameTime, arm.frame, arm.flags);
        for (const measure::PassResult& pass : arm.passes) row.times(pass.name, measure::metric::kPassTime, pass.summary, pass.flags);
        if (plan.path) addSpikes(row, arm);
        row.figure({"", std::string(measure::metric::kFirstFrame), "ms", "lower", arm.firstFrameMs, ""});
        for (const auto& [metric, base] : {std::pair(kToUnshadowed, unshadowed), std::pair(kToBare, bare)})
            if (base && base != &arm) row.ratio(metric, measure::ratioOf(measure::roundLogRatios(arm, *base), plan.sampling.seed));
        for (const Figure& figure : findings[i].figures) row.figure(figure);
        for (const PassNote& note : findings[i].leftOut) row.note(note.pass, kLeftOut, note.reason);
        if (!findings[i].fallback.empty()) row.note("", kFallback, findings[i].fallback);
        rows.metrics += row.text;
        rows.samples += sampleRows(point, i, arm, context);
    }
    return rows;
}

}  // namespace dapple::bench
