#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace dapple::measure {

/// Quantile by linear interpolation between order statistics, h = (n − 1) p: definition 7 of Hyndman & Fan
/// (1996), "Sample Quantiles in Statistical Packages", the default of R and NumPy.
/// `sorted` is ascending and not empty, p in [0, 1].
double quantileOfSorted(std::span<const double> sorted, double p);

/// Quantile 1/2 by the same definition: the mean of the two middle values when n is even. Not empty.
double median(std::span<const double> values);

struct Quartiles {
    double q1 = 0, median = 0, q3 = 0;
};
/// By the same definition. Not empty.
Quartiles quartiles(std::span<const double> values);

struct Interval {
    double lo = 0, hi = 0;
};

/// Percentile bootstrap (Efron & Tibshirani 1993, §13.3) of the median of `blockValues`, one value per block.
/// Blocks are resampled, not frames: frames of one block share the state of the machine, and resampling them
/// as if independent makes the interval too narrow. Deterministic in (values, seed). Not empty; a single
/// block gives a degenerate interval, which is why summaries ask for kMinBlocksForInterval.
Interval bootstrapMedian(std::span<const double> blockValues, uint64_t seed, double confidence = 0.95,
                         int resamples = 2000);

/// Lag-1 autocorrelation of values in the order of time, of their ranks so that single spikes do not hide it; raised by the
/// (1 + 4 ρ) / n by which the estimate of few values is too low (Marriott & Pope 1954); 0 … 0.9.
double autocorrelation(std::span<const double> valuesInTime);

/// 95 % interval of the median of blocks in the order of time: bootstrapMedian(), widened about the median by √((1 + ρ) / (1 − ρ)), as if
/// only the effective number of independent blocks, at least 5, had been seen, and by Student's t for so few (Bayley & Hammersley
/// 1946). Not below 0 where no value is. Of blocks whose noise is AR(1), by simulation of 5 to 40 blocks (statistics_test), 96 to 98 % of the
/// intervals hold the median at ρ = 0, 91 to 95 % at ρ = 0.5 and 86 to 94 % at ρ = 0.7.
Interval intervalOfMedian(std::span<const double> valuesInTime, uint64_t seed);

/// With fewer blocks than this even the interval [min, max] misses the median more often than one time in
/// ten (2 · 2^-n), so that no interval is given.
inline constexpr size_t kMinBlocksForInterval = 5;

/// (hi − lo) / 2 relative to `centre`; 0 for an interval of width 0.
double relativeHalfWidth(const Interval& interval, double centre);

enum class Outlier { none, mild, far };
/// Tukey's fences (1977): mild beyond 1.5, far beyond 3 interquartile ranges from the quartiles. Outliers are
/// flagged, never dropped. Empty in, empty out.
std::vector<Outlier> tukeyOutliers(std::span<const double> values);

/// ln(a[i] / b[i]). Log-ratios are symmetric in a and b, so that "twice as slow" and "twice as fast" cancel.
/// Equal lengths, all values > 0.
std::vector<double> logRatios(std::span<const double> a, std::span<const double> b);

struct Ratio {
    double value = 1;  ///< exp(median log-ratio)
    Interval ci;       ///< 95 %, exponentiated
    size_t n = 0;      ///< log-ratios it stands on
};
/// Nothing when there are fewer than kMinBlocksForInterval log-ratios, which are in the order of time.
std::optional<Ratio> ratioOf(std::span<const double> logRatios, uint64_t seed);

/// One-sided Mann-Kendall test for a rising trend: the standard normal score of Kendall's S with continuity
/// correction (Kendall 1975). 0 for fewer than four values. O(n²).
double risingTrendScore(std::span<const double> valuesInTime);

/// What a row of metrics.csv says about a sample of times.
struct Summary {
    size_t n = 0;       ///< valid samples; all other fields are meaningless when 0
    size_t blocks = 0;  ///< blocks with at least one valid sample
    double median = 0;  ///< median of the blocks' medians
    std::optional<Interval> ci;  ///< of that median: intervalOfMedian(); missing under kMinBlocksForInterval blocks
    double q1 = 0, q3 = 0, min = 0, max = 0;  ///< over samples
};
/// `blocks`: the valid samples of each block, in the order of time; a block may be empty.
Summary summarise(std::span<const std::vector<double>> blocks, uint64_t seed);

}  // namespace dapple::measure
