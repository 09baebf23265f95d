#include "bench/plan.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/terminal.h"
#include "bench/csv.h"

#include <fmt/format.h>
#include <re2/re2.h>

#include <algorithm>
#include <set>

namespace dapple::bench {
namespace {

/// Registry's order, so that a plan's columns do not depend on the order of a sweep's keys.
std::vector<std::string> axesOf(const Plan& plan) {
    std::vector<std::string> names;
    for (const shadow::Axis& axis : shadow::axes())
        if (std::any_of(plan.points.begin(), plan.points.end(),
                        [&](const PlannedPoint& p) { return p.spec.settings.contains(axis.name); }))
            names.push_back(axis.name);
    return names;
}

/// Throws UsageError where the scene lacks a view of the sweep's, has nothing that its motion moves, or its sun would meet the
/// horizon or the zenith.
void checkScene(const Sweep& sweep, const std::string& scene, const SceneFacts& facts) {
    for (const std::string& view : sweep.views)
        if (std::find(facts.views.begin(), facts.views.end(), view) == facts.views.end())
            throw base::UsageError(fmt::format("scene '{}': {}", scene, base::unknownName("view", view, facts.views)));
    if (!sweep.path) return;
    if (sweep.path->secondsPerFrame > 0 && !facts.facts.moving)
        throw base::UsageError(fmt::format("sweep '{}', [motion]: seconds_per_frame, but nothing moves in scene '{}'", sweep.name, scene));
    for (const int end : {0, sweep.path->frames - 1})
        if (const double e = sweep.path->at(facts.sun, end).elevation; !(e > 0 && e < 90))
            throw base::UsageError(fmt::format("sweep '{}', [motion]: in frame {} the sun of scene '{}' is {} degrees high; its path must stay between 0 and 90", sweep.name, end, scene, e));
}

}  // namespace

PointFilter::PointFilter(const std::vector<std::string>& patterns) {
    re2::RE2::Options options;
    options.set_case_sensitive(false);
    options.set_log_errors(false);
    for (const std::string& pattern : patterns) {
        patterns_.push_back(std::make_shared<const re2::RE2>(pattern, options));
        if (!patterns_.back()->ok())
            throw base::UsageError(
                fmt::format("--filter '{}' is no regular expression that RE2 takes ({}); write e.g. 'uniform|lispsm' "
                            "or 'size=(512|1024)'",
                            base::shortened(pattern, 60), base::shortened(patterns_.back()->error(), 80)));
    }
}

bool PointFilter::accepts(const PointSpec& spec) const {
    const std::string text = fmt::format("{} {} {} {} {}", spec.scene, pointText(spec), spec.view, spec.stressCase, spec.variant);
    return std::all_of(patterns_.begin(), patterns_.end(),
                       [&](const auto& p) { return re2::RE2::PartialMatch(text, *p); });
}

std::string pointId(const PointSpec& spec, uint64_t sceneHash) {
    base::Hasher hasher;
    hasher.text(spec.technique);
    hasher.value(shadow::technique(spec.technique).version);
    for (const auto& [axis, value] : spec.settings) {
        hasher.text(axis);
        hasher.text(value);
    }
    hasher.value(sceneHash);
    hasher.text(spec.stressCase);
    hasher.text(spec.view);
    hasher.value(spec.width);
    hasher.value(spec.height);
    if (spec.path) {
        const MotionPath& p = *spec.path;
        for (const double step : {p.azimuthPerFrame, p.elevationPerFrame, p.secondsPerFrame, p.metresPerFrame, p.heading, p.turnPerFrame}) hasher.value(step);
        hasher.value(spec.path->frames);
    }
    return base::hex16(hasher.digest());
}

std::string pointText(const PointSpec& spec) {
    std::string text = spec.technique;
    for (const auto& [axis, value] : spec.settings) text += fmt::format(" {}={}", axis, value);
    return text;
}

std::vector<Comparison> Plan::comparisons() const {
    std::vector<Comparison> result;
    const PointSpec* last = nullptr;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points[i].prunedBecause.empty()) continue;
        const PointSpec& spec = points[i].spec;
        if (!last || last->scene != spec.scene || last->variant != spec.variant || last->stressCase != spec.stressCase || last->view != spec.view)
            result.emplace_back();
        result.back().points.push_back(i);
        last = &spec;
    }
    return result;
}

std::string Plan::differing(const PointSpec& spec) const {
    std::string text;
    for (const auto& [axis, value] : spec.settings) {
        const bool varies =
            std::any_of(points.begin(), points.end(), [&, &axis = axis, &value = value](const PlannedPoint& other) {
                return other.spec.technique == spec.technique && other.spec.settings.at(axis) != value;
            });
        if (varies) text += fmt::format("{}{}={}", text.empty() ? "" : " ", axis, value);
    }
    return text;
}

std::string Plan::csv() const {
    const std::vector<std::string> axes = axesOf(*this);
    std::vector<std::string> row = {"point_id", "shard", "status", "reason", "scene", "technique", "view", "width", "height", "stress", "variant"};
    row.insert(row.end(), axes.begin(), axes.end());
    std::string text = csvRow(row);
    for (const PlannedPoint& point : points) {
        const PointSpec& s = point.spec;
        row = {point.id, "0", point.prunedBecause.empty() ? "planned" : "pruned", point.prunedBecause,
               s.scene, s.technique, s.view, fmt::format("{}", s.width), fmt::format("{}", s.height), s.stressCase, s.variant};
        for (const std::string& axis : axes) {
            const auto found = s.settings.find(axis);
            row.push_back(found == s.settings.end() ? std::string{} : found->second);
        }
        text += csvRow(row);
    }
    return text;
}

uint64_t Plan::hash() const {
    base::Hasher hasher;
    hasher.text(csv());
    for (const int count : {sampling.maxWarmupFrames, sampling.framesPerBlock, sampling.passFramesPerBlock, sampling.minBlocks, sampling.maxBlocks})
        hasher.value(count);
    for (const double limit : {sampling.ciTarget, sampling.timeoutSeconds, sampling.budgetSeconds}) hasher.value(limit);
    hasher.value(sampling.seed);
    return hasher.digest();
}

Plan makePlan(const Sweep& sweep, Workbench& workbench, const PointFilter& filter) {
    Plan plan{sweep.name, sweep.sampling, {}, {}, sweep.plot, sweep.path};
    const std::vector<std::string> variants = sweep.variants.empty() ? std::vector<std::string>{""} : sweep.variants;
    const std::vector<std::string> stress = sweep.stress.empty() ? std::vector<std::string>{""} : sweep.stress;
    const shadow::Limits limits = workbench.limits();
    std::set<std::string> ids;  // two entries of a sweep may name the same point: it is measured once
    for (const std::string& scene : sweep.scenes)
        for (const std::string& variant : variants) {
            std::vector<std::string> sceneSettings = sweep.sceneSettings;
            for (const std::string& setting : variantSettings(variant)) sceneSettings.push_back(setting);
            for (const std::string& stressName : stress) {
                std::optional<SceneFacts> built;  // a city takes seconds to grow: not one that the filter leaves out
                const auto facts = [&]() -> const SceneFacts& {
                    if (built) return *built;
                    built = workbench.sceneFacts(scene, sceneSettings, stressName);
                    checkScene(sweep, scene, *built);
                    plan.sceneHashes[scene + (variant.empty() ? "" : "[" + variant + "]") + (stressName.empty() ? "" : "/" + stressName)] = base::hex16(built->contentHash);
                    return *built;
                };
                for (const std::string& view : sweep.views.empty() ? std::vector{facts().views.at(0)} : sweep.views)
                    for (const TechniqueEntry& entry : sweep.entries)
                        for (const shadow::Settings& settings : expand(entry)) {
                            PointSpec spec{scene, sceneSettings, stressName, entry.technique, settings, view, sweep.width, sweep.height, variant, sweep.path};
                            if (!filter.accepts(spec)) continue;
                            const std::string id = pointId(spec, facts().contentHash);
                            if (!ids.insert(id).second) continue;
                            const auto reason = shadow::pruneReason(shadow::technique(entry.technique), settings, facts().facts, limits);
                            plan.points.push_back({id, std::move(spec), reason.value_or("")});
                        }
            }
        }
    if (plan.points.empty()) throw base::UsageError(fmt::format("sweep '{}': no point is left after --filter", sweep.name));
    return plan;
}

}  // namespace dapple::bench
