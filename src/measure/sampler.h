#pragma once

#include "measure/flags.h"
#include "measure/statistics.h"
#include "measure/subject.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dapple::measure {

/// How long and how carefully to sample.
struct SamplingPlan {
    int maxWarmupFrames = 60;      ///< per arm; warm when two successive 5-frame medians agree within warmupTolerance
    double warmupTolerance = 0.02;
    int framesPerBlock = 5;        ///< whole frames, 5…10
    int passFramesPerBlock = 1;    ///< frames timed pass by pass, after the block's whole frames; 0: no pass times
    int minBlocks = 10;            ///< per arm
    int maxBlocks = 60;            ///< per arm
    double ciTarget = 0.01;        ///< relative half-width of the 95 % interval of the median frame time
    double timeoutSeconds = 120;   ///< of one arm's own frames, warm-up included
    double budgetSeconds = 1e9;    ///< of the whole call; every arm gets one block even when it is spent
    uint64_t seed = 1;
    std::function<double()> clockSeconds;  ///< empty: CLOCK_MONOTONIC
};

/// One row of samples.csv.
struct Sample {
    int block = 0;  ///< of this arm, from 0; blocks 2r and 2r + 1 are the two halves of round r
    int order = 0;  ///< place of the block in the whole call, over all arms
    int frame = 0;  ///< within the block; frames timed pass by pass follow the whole ones
    int pass = -1;  ///< index into passNames(); −1: the whole frame
    std::optional<double> ms;  ///< missing when lost or not finite
    Flags flags;
};

struct PassResult {
    std::string name;
    Summary summary;  ///< milliseconds
    Flags flags;
};

struct ArmResult {
    std::optional<double> firstFrameMs;  ///< wall time of the very first frame: compilation, uploads, first use
    int warmupFrames = 0;
    Summary frame;     ///< milliseconds
    Flags flags;       ///< of the arm and of its whole frames
    std::vector<PassResult> passes;
    std::vector<Sample> samples;
    std::vector<std::optional<double>> blockMediansMs;  ///< by block; missing when the block had no valid frame
    std::string error;  ///< what the subject threw; it was not sampled any further. Empty: nothing
};

/// What is under way, for a progress bar.
struct SamplingProgress {
    enum class Phase { warmup, blocks } phase = Phase::warmup;
    size_t arm = 0;
    size_t blocksDone = 0;
    size_t blocksExpected = 0;  ///< lower bound: grows while intervals are too wide
};
using ProgressCallback = std::function<void(const SamplingProgress&)>;

/// Warms each arm up, then samples all of them in rounds: a round visits the arms in a random order, one block
/// each, and then in the reverse order (ABBA, so that a drift linear over the round cancels). All arms go on
/// until each is settled: its interval is narrow enough, or doubling its blocks no longer narrows it
/// (noisy), or it has maxBlocks. An arm over its own timeout drops out; the call ends when its budget is spent.
/// Results are parallel to `arms`. Deterministic given the arms' times, the clock and the seed.
/// Blocks. Throws UsageError when the plan is out of range; whatever `progress` throws ends the call.
std::vector<ArmResult> sample(std::span<Subject* const> arms, const SamplingPlan& plan,
                              const ProgressCallback& progress = {});

/// One ln(arm / base) per round in which both halves of both arms are valid: the mean of the halves' two
/// log-ratios. The round is the unit to resample, because a drift cancels within it and not within a block.
std::vector<double> roundLogRatios(const ArmResult& arm, const ArmResult& base);

}  // namespace dapple::measure
