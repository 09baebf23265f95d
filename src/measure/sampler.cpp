#include "measure/sampler.h"

#include "base/error.h"
#include "base/random.h"
#include "measure/timer.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <exception>
#include <numeric>

namespace dapple::measure {

namespace {

constexpr size_t kWarmupWindow = 5;
/// Doubling the blocks narrows an interval of independent blocks to 0.71 of its width. If it shrank by less
/// than a tenth, the blocks are not independent (drift, two modes), and more of them would only cost time.
constexpr double kStabilised = 0.9;
/// The machine counts as throttled when the last third of all blocks is this much slower than the first …
constexpr double kThrottledRatio = 1.05;
/// … and the rise is a trend with a one-sided p < 0.001, not one disturbance.
constexpr double kThrottledScore = 3.09;
/// Passes are timed in other frames than the whole: allow for the difference between the two.
constexpr double kPassesSlack = 1.05;

constexpr uint64_t kOrderPurpose = 0x6f72'6465;

struct Arm {
    Subject* subject;
    ArmResult result;
    std::vector<std::vector<double>> frameMs;               ///< [block]
    std::vector<std::vector<std::vector<double>>> passMs;   ///< [pass][block]
    std::vector<int> orders;                                ///< [block]
    std::vector<std::optional<double>> halfWidths;          ///< [block], relative, after that block
    double spentSeconds = 0;
    bool timedOut = false;

    bool active() const { return result.error.empty() && !timedOut; }
    int blocks() const { return int(frameMs.size()); }
    std::vector<double> validMedians() const {
        std::vector<double> medians;
        for (const auto& m : result.blockMediansMs)
            if (m) medians.push_back(*m);
        return medians;
    }
};

class Sampler {
public:
    Sampler(std::span<Subject* const> subjects, const SamplingPlan& plan, const ProgressCallback& progress)
        : plan_(plan), progress_(progress), clock_(plan.clockSeconds ? plan.clockSeconds : monotonicSeconds) {
        for (Subject* subject : subjects) {
            arms_.push_back({.subject = subject, .result = {}, .frameMs = {}, .passMs = {}, .orders = {}, .halfWidths = {}});
            arms_.back().passMs.resize(subject->passNames().size());
        }
    }

    std::vector<ArmResult> run() {
        start_ = clock_();
        for (size_t a = 0; a < arms_.size(); ++a) {
            report(SamplingProgress::Phase::warmup, a);
            guarded(a, [&] { warmUp(arms_[a]); });
        }
        for (size_t a = 0; a < arms_.size(); ++a)
            if (arms_[a].result.error.empty()) guarded(a, [&] { arms_[a].subject->beginBlocks(); });
        for (uint64_t round = 0; !finished(); ++round) runRound(round);
        std::vector<ArmResult> results;
        for (size_t a = 0; a < arms_.size(); ++a) results.push_back(finish(a));
        if (throttled())
            for (auto& result : results) addFlag(result.flags, flag::kThrottled);
        return results;
    }

private:
    bool timesPasses(const Arm& arm) const { return plan_.passFramesPerBlock > 0 && !arm.passMs.empty(); }
    bool budgetSpent() const { return clock_() - start_ >= plan_.budgetSeconds; }

    void report(SamplingProgress::Phase phase, size_t arm) const {
        if (!progress_) return;
        size_t done = 0, expected = 0;
        for (const Arm& a : arms_) {
            done += size_t(a.blocks());
            const int more = settled(a) ? 0 : 2;
            expected += size_t(a.active() ? std::max(plan_.minBlocks, a.blocks() + more) : a.blocks());
        }
        progress_({phase, arm, done, expected});
    }

    /// A subject that throws loses only itself; its message becomes its row's reason.
    template <class Work>
    void guarded(size_t index, const Work& work) {
        Arm& arm = arms_[index];
        const double before = clock_();
        try {
            work();
        } catch (const std::exception& e) {
            arm.result.error = e.what();
        }
        arm.spentSeconds += clock_() - before;
        if (arm.spentSeconds >= plan_.timeoutSeconds) arm.timedOut = true;
    }

    void warmUp(Arm& arm) {
        const double begin = clock_();
        std::vector<double> times;
        for (int frame = 0; frame < plan_.maxWarmupFrames; ++frame) {
            const double before = clock_();
            arm.subject->submitFrame(false);
            const auto drained = arm.subject->drain();
            if (frame == 0) arm.result.firstFrameMs = (clock_() - before) * 1e3;
            ++arm.result.warmupFrames;
            if (!drained.empty() && std::isfinite(drained.back().frameMs)) times.push_back(drained.back().frameMs);
            if (agree(times) || budgetSpent() || clock_() - begin >= plan_.timeoutSeconds) break;
        }
        if (timesPasses(arm)) {  // creates what only such frames use
            arm.subject->submitFrame(true);
            arm.subject->drain();
        }
    }

    bool agree(std::span<const double> times) const {
        if (times.size() < 2 * kWarmupWindow || times.size() % kWarmupWindow != 0) return false;
        const double last = median(times.last(kWarmupWindow));
        const double previous = median(times.last(2 * kWarmupWindow).first(kWarmupWindow));
        return std::abs(last - previous) <= plan_.warmupTolerance * previous;
    }

    bool finished() const {
        bool anyActive = false, allSettled = true, allHaveOne = true;
        for (const Arm& arm : arms_) {
            if (!arm.result.error.empty()) continue;
            allHaveOne &= arm.blocks() > 0;
            if (!arm.active()) continue;
            anyActive = true;
            allSettled &= settled(arm);
        }
        return allHaveOne && (!anyActive || allSettled || budgetSpent());
    }

    bool converged(const Arm& arm) const {
        return !arm.halfWidths.empty() && arm.halfWidths.back() && *arm.halfWidths.back() <= plan_.ciTarget;
    }

    bool settled(const Arm& arm) const {
        if (arm.blocks() < plan_.minBlocks) return false;
        if (converged(arm) || arm.blocks() >= plan_.maxBlocks) return true;
        const auto now = arm.halfWidths.back();
        if (!now) return true;  // hardly any block is valid; more will not be
        if (arm.blocks() < 2 * plan_.minBlocks) return false;
        const auto halfway = arm.halfWidths[arm.halfWidths.size() / 2 - 1];
        return halfway && *now >= kStabilised * *halfway;
    }

    void runRound(uint64_t round) {
        std::vector<size_t> order;
        for (size_t a = 0; a < arms_.size(); ++a)
            if (arms_[a].result.error.empty() && (arms_[a].active() || arms_[a].blocks() == 0)) order.push_back(a);
        const base::Random random(plan_.seed, round, kOrderPurpose);
        for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[((random.bits(i) >> 32) * i) >> 32]);
        for (size_t a : order) visit(a);
        for (size_t i = order.size(); i-- > 0;) visit(order[i]);
    }

    void visit(size_t index) {
        Arm& arm = arms_[index];
        if (!arm.result.error.empty()) return;
        if (arm.blocks() > 0 && (budgetSpent() || !arm.active())) return;
        guarded(index, [&] { runBlock(arm); });
        const auto medians = arm.validMedians();
        arm.halfWidths.emplace_back();
        if (medians.size() >= kMinBlocksForInterval)
            arm.halfWidths.back() =
                relativeHalfWidth(intervalOfMedian(medians, base::mix64(plan_.seed ^ index)), median(medians));
        report(SamplingProgress::Phase::blocks, index);
    }

    void runBlock(Arm& arm) {
        arm.frameMs.emplace_back();
        for (auto& blocks : arm.passMs) blocks.emplace_back();
        arm.orders.push_back(nextOrder_++);
        arm.result.blockMediansMs.emplace_back();

        const double begin = clock_();
        for (int i = 0; i < plan_.framesPerBlock; ++i) arm.subject->submitFrame(false);
        const auto whole = arm.subject->drain();
        const double wallMs = (clock_() - begin) * 1e3;
        recordFrames(arm, whole, wallMs);

        if (timesPasses(arm)) {
            for (int i = 0; i < plan_.passFramesPerBlock; ++i) arm.subject->submitFrame(true);
            recordPasses(arm, arm.subject->drain());
        }
        const auto& valid = arm.frameMs.back();
        if (!valid.empty()) arm.result.blockMediansMs.back() = median(valid);
    }

    Sample emptySample(const Arm& arm, int frame, int pass) const {
        return {.block = arm.blocks() - 1, .order = arm.orders.back(), .frame = frame, .pass = pass, .ms = {}, .flags = {}};
    }

    static void setValue(Sample& sample, double ms, const Flags& flags) {
        for (const auto& name : flags) addFlag(sample.flags, name);
        if (!std::isfinite(ms) || ms < 0) addFlag(sample.flags, flag::kNonfinite);
        else if (!hasFlag(sample.flags, flag::kLost)) sample.ms = ms;
    }

    void recordFrames(Arm& arm, std::span<const FrameTimes> frames, double wallMs) {
        if (frames.size() > size_t(plan_.framesPerBlock))
            throw std::logic_error("a subject returned more frames than were submitted");
        double sumMs = 0;
        const auto first = arm.result.samples.size();
        for (int i = 0; i < plan_.framesPerBlock; ++i) {
            Sample s = emptySample(arm, i, -1);
            if (size_t(i) < frames.size()) setValue(s, frames[size_t(i)].frameMs, frames[size_t(i)].flags);
            else addFlag(s.flags, flag::kLost);
            if (s.ms && isValidSample(s.flags)) {
                arm.frameMs.back().push_back(*s.ms);
                sumMs += *s.ms;
            }
            arm.result.samples.push_back(std::move(s));
        }
        // One device runs one frame after the other, so that the frames' sum is bounded by the wall.
        if (exceedsWall(sumMs, wallMs))
            for (size_t i = first; i < arm.result.samples.size(); ++i)
                addFlag(arm.result.samples[i].flags, flag::kTimerGtWall);
    }

    void recordPasses(Arm& arm, std::span<const FrameTimes> frames) {
        const auto passes = arm.passMs.size();
        for (int i = 0; i < plan_.passFramesPerBlock; ++i)
            for (size_t p = 0; p < passes; ++p) {
                Sample s = emptySample(arm, plan_.framesPerBlock + i, int(p));
                const FrameTimes* times = size_t(i) < frames.size() ? &frames[size_t(i)] : nullptr;
                if (times && p < times->passMs.size()) setValue(s, times->passMs[p], times->flags);
                else addFlag(s.flags, flag::kLost);
                if (s.ms && isValidSample(s.flags)) arm.passMs[p].back().push_back(*s.ms);
                arm.result.samples.push_back(std::move(s));
            }
    }

    static void flagOutliers(ArmResult& result, int pass) {
        std::vector<Sample*> valid;
        std::vector<double> values;
        for (Sample& s : result.samples)
            if (s.pass == pass && s.ms && isValidSample(s.flags)) {
                valid.push_back(&s);
                values.push_back(*s.ms);
            }
        const auto outliers = tukeyOutliers(values);
        for (size_t i = 0; i < valid.size(); ++i) {
            if (outliers[i] == Outlier::mild) addFlag(valid[i]->flags, flag::kOutlier);
            if (outliers[i] == Outlier::far) addFlag(valid[i]->flags, flag::kFarOutlier);
        }
    }

    /// The samples' flags that also concern the row; single outliers do not.
    static void raise(const ArmResult& result, int pass, Flags& flags) {
        for (const Sample& s : result.samples)
            if (s.pass == pass)
                for (const auto& name : s.flags)
                    if (name != flag::kOutlier && name != flag::kFarOutlier) addFlag(flags, name);
    }

    void flagWidth(const Summary& summary, Flags& flags) const {
        if (!summary.ci || relativeHalfWidth(*summary.ci, summary.median) > plan_.ciTarget)
            addFlag(flags, flag::kNoisy);
    }

    ArmResult finish(size_t index) {
        Arm& arm = arms_[index];
        ArmResult& result = arm.result;
        const uint64_t seed = base::mix64(plan_.seed ^ index);
        result.frame = summarise(arm.frameMs, seed);
        flagOutliers(result, -1);
        raise(result, -1, result.flags);
        flagWidth(result.frame, result.flags);
        if (result.error.empty() && (arm.timedOut || !settled(arm))) addFlag(result.flags, flag::kTimeout);

        double passesMs = 0;
        for (size_t p = 0; timesPasses(arm) && p < arm.passMs.size(); ++p) {
            PassResult pass{arm.subject->passNames()[p], summarise(arm.passMs[p], base::mix64(seed ^ (p + 1))), {}};
            flagOutliers(result, int(p));
            raise(result, int(p), pass.flags);
            flagWidth(pass.summary, pass.flags);
            passesMs += pass.summary.n > 0 ? pass.summary.median : 0;
            result.passes.push_back(std::move(pass));
        }
        const double frameMs = result.frame.ci ? result.frame.ci->hi : result.frame.max;
        if (passesMs > kPassesSlack * frameMs)
            for (auto& pass : result.passes) addFlag(pass.flags, flag::kPassesGtFrame);
        return std::move(result);
    }

    /// Clocks that fall slow every arm alike, so the test pools all arms: each block relative to its own arm's
    /// median, in the order of time.
    bool throttled() const {
        std::vector<double> relative(size_t(nextOrder_), 0.0);
        for (const Arm& arm : arms_) {
            std::vector<double> medians;
            for (const auto& block : arm.frameMs)
                if (!block.empty()) medians.push_back(median(block));
            if (medians.empty()) continue;
            const double centre = median(medians);
            for (size_t b = 0; b < arm.frameMs.size(); ++b)
                if (!arm.frameMs[b].empty() && centre > 0)
                    relative[size_t(arm.orders[b])] = median(arm.frameMs[b]) / centre;
        }
        std::erase(relative, 0.0);
        const auto third = relative.size() / 3;
        if (third < 3) return false;
        const std::span<const double> all(relative);
        return median(all.last(third)) > kThrottledRatio * median(all.first(third)) &&
               risingTrendScore(all) > kThrottledScore;
    }

    const SamplingPlan& plan_;
    const ProgressCallback& progress_;
    std::function<double()> clock_;
    std::vector<Arm> arms_;
    double start_ = 0;
    int nextOrder_ = 0;
};

void requirePlan(const SamplingPlan& plan) {
    const auto require = [](bool ok, std::string_view what) {
        if (!ok) throw base::UsageError(fmt::format("sampling plan: {}", what));
    };
    require(plan.framesPerBlock >= 5 && plan.framesPerBlock <= 10, "frames per block must be in 5...10");
    require(plan.passFramesPerBlock >= 0, "frames per block timed by pass must not be negative");
    require(plan.minBlocks >= 1 && plan.maxBlocks >= plan.minBlocks, "blocks must be 1 <= least <= most");
    require(plan.maxWarmupFrames >= 1, "at least one warm-up frame is needed");
    require(plan.ciTarget > 0 && plan.warmupTolerance > 0, "tolerances must be positive");
    require(plan.timeoutSeconds > 0 && plan.budgetSeconds > 0, "time limits must be positive");
}

}  // namespace

std::vector<ArmResult> sample(std::span<Subject* const> arms, const SamplingPlan& plan,
                              const ProgressCallback& progress) {
    requirePlan(plan);
    return Sampler(arms, plan, progress).run();
}

std::vector<double> roundLogRatios(const ArmResult& arm, const ArmResult& base) {
    const auto& a = arm.blockMediansMs;
    const auto& b = base.blockMediansMs;
    std::vector<double> ratios;
    for (size_t i = 0; i + 1 < std::min(a.size(), b.size()); i += 2)
        if (a[i] && a[i + 1] && b[i] && b[i + 1])
            ratios.push_back((std::log(*a[i] / *b[i]) + std::log(*a[i + 1] / *b[i + 1])) / 2);
    return ratios;
}

}  // namespace dapple::measure
