#include "measure/sampler.h"

#include "base/error.h"
#include "measure/timers/fake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

namespace dapple::measure {
namespace {

/// A frame of two passes under the fake timer. `spoil` may change or drop frames before they are returned.
class FakeSubject : public Subject {
public:
    FakeSubject(FakeCosts costs, VirtualClock& clock) : timer(std::move(costs), clock) {}
    const std::vector<std::string>& passNames() const override { return names; }
    void submitFrame(bool perPass) override {
        timer.beginFrame(perPass);
        for (size_t i = 0; i < names.size(); ++i) {
            timer.beginPass();
            timer.endPass();
        }
        timer.endFrame();
        ++submitted;
    }
    std::vector<FrameTimes> drain() override {
        auto frames = timer.drain();
        if (spoil) spoil(frames);
        return frames;
    }

    FakeTimer timer;
    std::vector<std::string> names{"depth", "shade"};
    int submitted = 0;
    std::function<void(std::vector<FrameTimes>&)> spoil;
};

struct Bench {
    VirtualClock clock;
    std::vector<std::unique_ptr<FakeSubject>> subjects;
    SamplingPlan plan;

    Bench() {
        plan.clockSeconds = [this] { return clock.seconds; };
    }
    FakeSubject& add(double frameMs, double noise, uint64_t seed, double driftPerSecond = 0) {
        subjects.push_back(std::make_unique<FakeSubject>(
            FakeCosts{{0.25 * frameMs, 0.75 * frameMs}, noise, driftPerSecond, seed}, clock));
        return *subjects.back();
    }
    std::vector<ArmResult> run(const ProgressCallback& progress = {}) {
        std::vector<Subject*> arms;
        for (auto& s : subjects) arms.push_back(s.get());
        return sample(arms, plan, progress);
    }
};

TEST(Sampler, FindsTrueTenPercentAndNoDifferenceInAA) {
    int found = 0, falseAlarms = 0;
    constexpr int kRuns = 40;
    for (uint64_t run = 0; run < kRuns; ++run) {
        Bench bench;
        bench.add(10, 0.05, 3 * run);
        bench.add(10, 0.05, 3 * run + 1);
        bench.add(11, 0.05, 3 * run + 2);
        bench.plan.seed = run;
        const auto r = bench.run();
        const auto aa = ratioOf(roundLogRatios(r[1], r[0]), run), slow = ratioOf(roundLogRatios(r[2], r[0]), run);
        ASSERT_TRUE(aa && slow);
        found += slow->ci.lo > 1.03;
        falseAlarms += aa->ci.lo > 1.03 || aa->ci.hi < 1 / 1.03;
        EXPECT_NEAR(std::log(slow->value), std::log(1.1), 0.03) << run;
    }
    EXPECT_EQ(found, kRuns);
    EXPECT_EQ(falseAlarms, 0);
}

TEST(Sampler, VisitsArmsInRandomPalindromes) {
    Bench bench;
    for (uint64_t a = 0; a < 4; ++a) bench.add(5, 0.02, a);
    bench.plan.minBlocks = bench.plan.maxBlocks = 40;
    const auto results = bench.run();
    std::map<int, size_t> armAt;
    for (size_t a = 0; a < results.size(); ++a)
        for (const Sample& s : results[a].samples) armAt[s.order] = a;
    ASSERT_EQ(armAt.size(), 160u);
    std::set<std::vector<size_t>> orders;
    std::array<int, 4> first{};
    for (int round = 0; round < 20; ++round) {
        std::vector<size_t> forth, back;
        for (int i = 0; i < 4; ++i) {
            forth.push_back(armAt[round * 8 + i]);
            back.push_back(armAt[round * 8 + 7 - i]);
        }
        EXPECT_EQ(forth, back) << round;
        EXPECT_EQ(std::set<size_t>(forth.begin(), forth.end()).size(), 4u);
        orders.insert(forth);
        ++first[forth[0]];
    }
    EXPECT_GT(orders.size(), 8u);  // of 24; 20 uniform draws hit 13.8 different ones on average
    for (int count : first) EXPECT_GT(count, 0);
}

TEST(Sampler, LinearDriftDoesNotBiasTheRatio) {
    Bench bench;
    bench.add(10, 0.002, 1, 0.05);  // all machine time grows by 5 % a second
    bench.add(12, 0.002, 2, 0.05);
    bench.plan.minBlocks = bench.plan.maxBlocks = 20;
    const auto r = bench.run();
    ASSERT_GT(r[0].blockMediansMs.back().value() / r[0].blockMediansMs.front().value(), 1.1);
    const auto ratio = ratioOf(roundLogRatios(r[1], r[0]), 1);
    ASSERT_TRUE(ratio);
    EXPECT_NEAR(ratio->value, 1.2, 0.004);
    EXPECT_LE(ratio->ci.lo, 1.2);
    EXPECT_GE(ratio->ci.hi, 1.2);
    for (const auto& arm : r) EXPECT_TRUE(hasFlag(arm.flags, flag::kThrottled));
}

TEST(Sampler, SteadyMachineIsNotThrottled) {
    for (uint64_t seed = 0; seed < 50; ++seed) {
        Bench bench;
        bench.add(10, 0.1, seed);
        bench.plan.minBlocks = bench.plan.maxBlocks = 20;
        EXPECT_FALSE(hasFlag(bench.run()[0].flags, flag::kThrottled)) << seed;
    }
}

TEST(Sampler, StopsAtTheTargetAndSaysWhenItIsMissed) {
    Bench quiet;
    quiet.add(10, 0.001, 1);
    const auto q = quiet.run()[0];
    EXPECT_EQ(q.frame.blocks, 10u);
    EXPECT_EQ(q.frame.n, 50u);
    EXPECT_TRUE(q.flags.empty()) << joinFlags(q.flags);
    ASSERT_TRUE(q.frame.ci);
    EXPECT_LE(relativeHalfWidth(*q.frame.ci, q.frame.median), 0.01);
    EXPECT_NEAR(q.frame.median, 10, 0.02);
    ASSERT_EQ(q.passes.size(), 2u);
    EXPECT_NEAR(q.passes[0].summary.median, 2.5, 0.01);
    EXPECT_NEAR(q.passes[1].summary.median, 7.5, 0.03);
    EXPECT_EQ(q.passes[1].summary.n, 10u);

    Bench loud;
    loud.add(10, 0.3, 1);
    const auto l = loud.run()[0];
    EXPECT_GE(l.frame.blocks, 20u);
    EXPECT_LE(l.frame.blocks, 60u);
    EXPECT_EQ(l.flags, Flags{"noisy"});
}

TEST(Sampler, StabilisedNoiseEndsBeforeTheBlocksRunOut) {
    Bench bench;  // two modes by turns of blocks: no number of blocks narrows the interval
    auto& subject = bench.add(10, 0.001, 1);
    int drains = 0;
    subject.spoil = [&](std::vector<FrameTimes>& frames) {
        const double factor = drains++ % 4 < 2 ? 0.5 : 1;
        for (auto& f : frames) f.frameMs *= factor;
    };
    bench.plan.maxBlocks = 1000;
    const auto r = bench.run()[0];
    EXPECT_LT(r.frame.blocks, 100u);
    EXPECT_TRUE(hasFlag(r.flags, flag::kNoisy));
}

TEST(Sampler, WarmsUpUntilTwoMediansAgree) {
    Bench bench;
    auto& subject = bench.add(10, 0, 1);
    int frames = 0;
    subject.spoil = [&](std::vector<FrameTimes>& drained) {  // 23 slow frames, the first much slower on the wall
        for (auto& f : drained)
            if (++frames <= 23) f.frameMs *= 3.0 - 0.08 * frames;
        if (frames == 1) bench.clock.seconds += 0.25;
    };
    const auto r = bench.run()[0];
    EXPECT_NEAR(r.firstFrameMs.value(), 260, 1e-9);
    EXPECT_EQ(r.warmupFrames, 35);  // 25…30 is the first window wholly warm, 31…35 agrees with it
    EXPECT_NEAR(r.frame.max, 10, 1e-9);

    Bench restless;
    auto& never = restless.add(10, 0, 1);
    double factor = 1;
    never.spoil = [&](std::vector<FrameTimes>& drained) {
        for (auto& f : drained) f.frameMs *= factor *= 1.05;
    };
    EXPECT_EQ(restless.run()[0].warmupFrames, 60);
}

TEST(Sampler, TimeoutEndsOneArmAndBudgetEndsAll) {
    Bench bench;
    bench.add(1, 0.001, 1);
    bench.add(1000, 0.001, 2);
    bench.plan.timeoutSeconds = 40;
    const auto r = bench.run();
    EXPECT_TRUE(r[0].flags.empty()) << joinFlags(r[0].flags);
    EXPECT_EQ(r[0].frame.blocks, 10u);
    EXPECT_TRUE(hasFlag(r[1].flags, flag::kTimeout));
    EXPECT_EQ(r[1].frame.blocks, 5u);  // 11 s of warm-up, then 6 s a block: 41 s
    EXPECT_LT(bench.clock.seconds, 42);

    Bench capped;
    capped.add(100, 0.001, 1);
    capped.add(100, 0.001, 2);
    capped.plan.budgetSeconds = 6;
    const auto c = capped.run();
    EXPECT_LE(capped.clock.seconds, 6 + 0.6);  // the block under way is finished
    for (const auto& arm : c) {
        EXPECT_TRUE(hasFlag(arm.flags, flag::kTimeout));
        EXPECT_GT(arm.frame.n, 0u);
    }

    Bench hopeless;  // spent in the first warm-up: every arm still gets one block
    for (uint64_t a = 0; a < 3; ++a) hopeless.add(100, 0.001, a);
    hopeless.plan.budgetSeconds = 0.05;
    for (const auto& arm : hopeless.run()) {
        EXPECT_EQ(arm.frame.blocks, 1u);
        EXPECT_EQ(arm.frame.n, 5u);
        EXPECT_EQ(arm.flags, (Flags{"noisy", "timeout"}));
    }
}

TEST(Sampler, LostAndImpossibleFramesAreFlaggedAndLeftOut) {
    Bench bench;
    auto& subject = bench.add(10, 0, 1);
    int drains = 0;
    subject.spoil = [&](std::vector<FrameTimes>& frames) {
        if (frames.size() != 5) return;
        if (drains == 0) frames.pop_back();
        if (drains == 1) frames[0] = {.frameMs = 0, .passMs = {}, .flags = {"lost"}};
        if (drains == 2) frames[1].frameMs = std::numeric_limits<double>::quiet_NaN();
        if (drains == 3) frames[2].frameMs = -1;
        if (drains == 4) frames[3] = {.frameMs = 4e9, .passMs = {}, .flags = {"wrap"}};
        ++drains;
    };
    const auto r = bench.run()[0];
    EXPECT_EQ(r.frame.n, 45u);
    EXPECT_DOUBLE_EQ(r.frame.min, 10);
    EXPECT_DOUBLE_EQ(r.frame.max, 10);
    EXPECT_EQ(r.flags, (Flags{"lost", "nonfinite", "wrap"}));
    size_t frames = 0, lost = 0;
    for (const Sample& s : r.samples) {
        if (s.pass >= 0) continue;
        ++frames;
        lost += hasFlag(s.flags, flag::kLost);
        const bool missing = hasFlag(s.flags, flag::kLost) || hasFlag(s.flags, flag::kNonfinite);
        EXPECT_EQ(s.ms.has_value(), !missing);
        if (hasFlag(s.flags, flag::kWrap)) {
            EXPECT_EQ(s.ms.value(), 4e9);
        }
    }
    EXPECT_EQ(frames, 50u);  // none silently dropped
    EXPECT_EQ(lost, 2u);
    EXPECT_EQ(r.samples.size(), 50u + 20u);
}

TEST(Sampler, AllFramesLostIsAResultWithoutValues) {
    Bench bench;
    bench.add(10, 0, 1).spoil = [](std::vector<FrameTimes>& frames) { frames.clear(); };
    const auto r = bench.run()[0];
    EXPECT_EQ(r.frame.n, 0u);
    EXPECT_FALSE(r.frame.ci);
    EXPECT_EQ(r.flags, (Flags{"lost", "noisy"}));
}

TEST(Sampler, FlagsTimersThatExceedTheWallAndPassesThatExceedTheFrame) {
    Bench fast;
    fast.add(10, 0.001, 1).spoil = [](std::vector<FrameTimes>& frames) {
        for (auto& f : frames) f.frameMs *= 1.1;
    };
    EXPECT_EQ(fast.run()[0].flags, Flags{"timer_gt_wall"});

    Bench fenced;
    fenced.add(10, 0.001, 1).spoil = [](std::vector<FrameTimes>& frames) {
        for (auto& f : frames)
            for (double& ms : f.passMs) ms *= 1.2;
    };
    const auto r = fenced.run()[0];
    EXPECT_TRUE(r.flags.empty());
    for (const auto& pass : r.passes) EXPECT_EQ(pass.flags, Flags{"passes_gt_frame"});
}

TEST(Sampler, OutliersAreKeptAndFlagged) {
    Bench bench;
    int drains = 0;
    bench.add(10, 0.01, 1).spoil = [&](std::vector<FrameTimes>& frames) {
        if (frames.size() == 5 && drains++ == 3) frames[2].frameMs = 30, bench.clock.seconds += 0.02;
    };
    const auto r = bench.run()[0];
    EXPECT_EQ(r.frame.max, 30);
    EXPECT_EQ(r.frame.n, 50u);
    size_t far = 0;
    for (const Sample& s : r.samples)
        if (hasFlag(s.flags, flag::kFarOutlier)) {
            ++far;
            EXPECT_EQ(s.ms.value(), 30);
            EXPECT_EQ(s.block, 3);
            EXPECT_EQ(s.frame, 2);
        }
    EXPECT_EQ(far, 1u);
}

TEST(Sampler, ASubjectThatThrowsLosesOnlyItself) {
    Bench bench;
    bench.add(10, 0.001, 1);
    bench.add(10, 0.001, 2).spoil = [](std::vector<FrameTimes>& frames) {
        if (frames.size() == 5) throw std::runtime_error("shader lost");
    };
    const auto r = bench.run();
    EXPECT_EQ(r[1].error, "shader lost");
    EXPECT_EQ(r[1].frame.n, 0u);
    EXPECT_TRUE(r[0].error.empty());
    EXPECT_EQ(r[0].frame.n, 50u);
}

TEST(Sampler, SameSeedSameResult) {
    const auto run = [](uint64_t seed) {
        Bench bench;
        bench.add(10, 0.05, 1);
        bench.add(11, 0.05, 2);
        bench.plan.seed = seed;
        return bench.run();
    };
    const auto a = run(4), b = run(4), c = run(5);
    ASSERT_EQ(a[1].samples.size(), b[1].samples.size());
    for (size_t i = 0; i < a[1].samples.size(); ++i) {
        EXPECT_EQ(a[1].samples[i].ms, b[1].samples[i].ms);
        EXPECT_EQ(a[1].samples[i].order, b[1].samples[i].order);
    }
    EXPECT_EQ(a[0].frame.ci->lo, b[0].frame.ci->lo);
    std::vector<int> orderA, orderC;
    for (const Sample& s : a[0].samples) orderA.push_back(s.order);
    for (const Sample& s : c[0].samples) orderC.push_back(s.order);
    EXPECT_NE(orderA, orderC);
}

TEST(Sampler, ProgressEndsCompleteAndMayAbort) {
    Bench bench;
    bench.add(10, 0.001, 1);
    bench.add(10, 0.001, 2);
    SamplingProgress last;
    size_t calls = 0;
    bench.run([&](const SamplingProgress& p) {
        EXPECT_GE(p.blocksDone, last.blocksDone);
        EXPECT_LE(p.blocksDone, p.blocksExpected);
        last = p;
        ++calls;
    });
    EXPECT_EQ(last.blocksDone, 20u);
    EXPECT_EQ(last.blocksExpected, 20u);
    EXPECT_EQ(calls, 22u);
    EXPECT_THROW(bench.run([](const SamplingProgress&) { throw std::runtime_error("interrupted"); }),
                 std::runtime_error);
}

TEST(Sampler, RejectsPlansOutOfRange) {
    Bench bench;
    bench.add(10, 0, 1);
    bench.plan.framesPerBlock = 4;
    EXPECT_THROW(bench.run(), base::UsageError);
    bench.plan.framesPerBlock = 5;
    bench.plan.maxBlocks = 9;
    EXPECT_THROW(bench.run(), base::UsageError);
}

}  // namespace
}  // namespace dapple::measure
