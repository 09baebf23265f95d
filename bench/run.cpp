#include "bench/run.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "bench/csv.h"
#include "bench/interrupt.h"
#include "bench/provenance.h"
#include "bench/rows.h"
#include "bench/run_folder.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <new>

namespace dapple::bench {
namespace {

class Runner {
public:
    Runner(const Plan& plan, Workbench& workbench, const RunOptions& options)
        : plan_(plan), workbench_(workbench), options_(options), comparisons_(plan.comparisons()),
          folder_(options, {plan.sweepName, base::hex16(plan.hash()), workbench.backend(), originOf(workbench.identityJson())}, comparisonOf()),
          progress_("run (%)", 100) {
        for (const Comparison& c : comparisons_) pointCount_ += c.points.size();
        for (const PlannedPoint& point : plan.points) {
            const std::string settings = plan.differing(point.spec);
            labels_.push_back(point.spec.technique + (settings.empty() ? "" : " " + settings));
        }
        if (pointCount_ < plan.points.size())
            base::logInfo(fmt::format("{} of {} points are pruned; plan.csv says why", plan.points.size() - pointCount_, plan.points.size()));
    }

    RunOutcome run() {
        if (folder_.complete()) {
            base::logInfo(fmt::format("{}: the run is complete; nothing to resume", options_.folder));
            return outcome();
        }
        if (const std::string why = workbench_.timerRejected(); !why.empty()) {
            rejected_ = true;
            base::logWarning(fmt::format("timer {} failed its self-test ({}): its times may be wrong by any factor; every row is flagged {}", workbench_.backend(), why,
                                         measure::flag::kTimerRejected));
        }
        base::writeFile(std::filesystem::path(options_.folder) / "plan.csv", plan_.csv());
        for (size_t i = 0; i < comparisons_.size(); ++i) {
            if (!folder_.done(i)) measure(i);
            finishedPoints_ += comparisons_[i].points.size();
            const std::string& scene = specOf(comparisons_[i], 0).scene;
            const bool needed = std::any_of(comparisons_.begin() + static_cast<ptrdiff_t>(i) + 1, comparisons_.end(),
                                            [&](const Comparison& c) { return specOf(c, 0).scene == scene; });
            if (!needed) workbench_.releaseScene(scene);
        }
        folder_.finish(plan_.csv(), runJson());
        return outcome();
    }

private:
    std::map<std::string, size_t> comparisonOf() const {
        std::map<std::string, size_t> result;
        for (size_t i = 0; i < comparisons_.size(); ++i)
            for (const size_t point : comparisons_[i].points) result[plan_.points[point].id] = i;
        return result;
    }

    const PointSpec& specOf(const Comparison& comparison, size_t i) const { return plan_.points[comparison.points[i]].spec; }

    void measure(size_t index) {
        const Comparison& comparison = comparisons_[index];
        const size_t count = comparison.points.size();
        std::vector<PointFindings> findings(count);
        std::vector<std::unique_ptr<OpenPoint>> open(count);
        const auto forEachPoint = [&](double shareBefore, double share, const auto& work) {
            for (size_t i = 0; i < count; ++i) {
                report(index, shareBefore + share * static_cast<double>(i) / static_cast<double>(count),
                       labels_[comparison.points[i]]);
                if (findings[i].failure.empty()) findings[i].failure = failureOf([&] { work(i); });
                if (!findings[i].failure.empty()) open[i].reset();
            }
        };
        forEachPoint(0, 0.2, [&](size_t i) { open[i] = workbench_.open(specOf(comparison, i)); });
        const auto arms = sample(index, open, findings);
        // After sampling: what these frames compile or cache must not hide what the first frame costs.
        forEachPoint(0.8, 0.2, [&](size_t i) {
            findings[i].figures = open[i]->counters();
            for (Figure& figure : open[i]->errors()) findings[i].figures.push_back(std::move(figure));
            findings[i].leftOut = open[i]->leftOut();
            findings[i].fallback = open[i]->fallback();
        });

        const RowContext context{folder_.runId(), workbench_.backend(), folder_.process(), rejected_};
        const ComparisonRows rows = comparisonRows(plan_, comparison, findings, arms, context);
        folder_.append(index, rows.metrics, rows.samples);
        for (size_t i = 0; i < count; ++i)
            if (!findings[i].failure.empty())
                base::logWarning(fmt::format("{} {} failed: {}", specOf(comparison, i).scene, pointText(specOf(comparison, i)), oneLine(findings[i].failure)));
    }

    /// Times of all open points, interleaved; parallel to them.
    std::vector<std::optional<measure::ArmResult>> sample(size_t index, const std::vector<std::unique_ptr<OpenPoint>>& open,
                                                          std::vector<PointFindings>& findings) {
        std::vector<measure::Subject*> subjects;
        std::vector<size_t> pointOf;
        for (size_t i = 0; i < open.size(); ++i)
            if (open[i]) {
                subjects.push_back(open[i].get());
                pointOf.push_back(i);
            }
        std::vector<std::optional<measure::ArmResult>> arms(open.size());
        if (subjects.empty()) return arms;
        measure::SamplingPlan sampling = plan_.sampling;
        sampling.clockSeconds = workbench_.clock();
        auto results = measure::sample(subjects, sampling, [&](const measure::SamplingProgress& p) {
            const double share = p.blocksExpected > 0 ? static_cast<double>(p.blocksDone) / static_cast<double>(p.blocksExpected) : 0;
            report(index, 0.2 + 0.6 * share, labels_[comparisons_[index].points[pointOf[p.arm]]]);
        });
        for (size_t a = 0; a < results.size(); ++a) {
            findings[pointOf[a]].failure = results[a].error;
            arms[pointOf[a]] = std::move(results[a]);
        }
        return arms;
    }

    /// Why `work` failed, or "". A point that fails is a row, not the end of the run.
    template <class Work>
    static std::string failureOf(const Work& work) {
        try {
            work();
        } catch (const std::bad_alloc&) {
            return "out of memory";
        } catch (const std::exception& e) {
            return *e.what() ? e.what() : "unknown";
        }
        return "";
    }

    /// Progress, and the place where Ctrl-C is noticed. `share`: of this comparison, 0 … 1.
    void report(size_t index, double share, const std::string& detail) {
        const auto total = static_cast<double>(std::max<size_t>(pointCount_, 1));
        const double done = static_cast<double>(finishedPoints_) + share * static_cast<double>(comparisons_[index].points.size());
        progress_.update(static_cast<size_t>(100 * done / total), fmt::format("{} {}", specOf(comparisons_[index], 0).scene, detail));
        if (interrupt_.requested())
            throw base::Error(base::ExitCode::interrupted,
                              fmt::format("interrupted; finished comparisons are safe: run the same command with --resume to go on in {}", options_.folder));
    }

    std::string runJson() const {
        nlohmann::ordered_json json;
        json["schema"] = kSchema;
        json["run_id"] = folder_.runId();
        json["plan_hash"] = base::hex16(plan_.hash());
        json["sweep"] = plan_.sweepName;
        json["argv"] = commandLine();
        json["start"] = folder_.started();
        json["end"] = utcNow();
        json["processes"] = folder_.process() + 1;
        json["backend"] = workbench_.backend();
        for (const std::string& origin : folder_.origins()) json["origins"].push_back(nlohmann::ordered_json::parse(origin));
        json["build"] = buildJson();
        json["machine"] = nlohmann::ordered_json::parse(workbench_.identityJson());
        if (!plan_.plot.x.empty()) json["plot"] = {{"x", plan_.plot.x}, {"y", plan_.plot.y}, {"columns", plan_.plot.columns}};
        if (const auto& p = plan_.path)
            json["motion"] = {{"sun_azimuth_per_frame", p->azimuthPerFrame}, {"sun_elevation_per_frame", p->elevationPerFrame},
                              {"seconds_per_frame", p->secondsPerFrame}, {"camera_metres_per_frame", p->metresPerFrame}, {"camera_heading", p->heading},
                              {"camera_turn_per_frame", p->turnPerFrame}, {"frames", p->frames}};
        json["seeds"] = {{"sampling", plan_.sampling.seed}};
        json["hashes"] = {{"scenes", plan_.sceneHashes}, {"shaders", shadersHash()}};
        return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    }

    /// Counted from the file, because a resumed run did not see the points of the process before.
    RunOutcome outcome() const {
        RunOutcome result;
        result.points = pointCount_;
        const CsvTable table(base::readFile(folder_.metricsPath()), folder_.metricsPath().string());
        for (size_t row = 0; row < table.rows(); ++row) {
            result.failed += table.at(row, "status") == "failed";
            result.invalid += table.at(row, "status") == "invalid";
        }
        return result;
    }

    const Plan& plan_;
    Workbench& workbench_;
    const RunOptions& options_;
    InterruptScope interrupt_;
    std::vector<Comparison> comparisons_;
    RunFolder folder_;
    base::Progress progress_;
    std::vector<std::string> labels_;  ///< of the planned points: what tells one from another, for the line of progress
    size_t pointCount_ = 0, finishedPoints_ = 0;
    bool rejected_ = false;  ///< the timer, by its self-test
};

}  // namespace

RunOutcome runPlan(const Plan& plan, Workbench& workbench, const RunOptions& options) {
    if (plan.comparisons().empty())
        throw base::UsageError(fmt::format("every point of sweep '{}' is pruned: {}", plan.sweepName, plan.points.at(0).prunedBecause));
    return Runner(plan, workbench, options).run();
}

void requireClean(const RunOutcome& outcome, const std::string& folder) {
    if (outcome.clean()) return;
    throw base::Error(base::ExitCode::failed, fmt::format("{} of {} points failed and {} rows are invalid; see status and flags in {}/metrics.csv",
                                                          outcome.failed, outcome.points, outcome.invalid, folder));
}

}  // namespace dapple::bench
