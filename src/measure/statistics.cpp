#include "measure/statistics.h"

#include "base/random.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace dapple::measure {

namespace {

std::vector<double> sortedCopy(std::span<const double> values) {
    std::vector<double> sorted(values.begin(), values.end());
    std::sort(sorted.begin(), sorted.end());
    return sorted;
}

}  // namespace

double quantileOfSorted(std::span<const double> sorted, double p) {
    assert(!sorted.empty() && p >= 0 && p <= 1);
    const double h = double(sorted.size() - 1) * p;
    const auto lower = std::min(size_t(h), sorted.size() - 1);
    const auto upper = std::min(lower + 1, sorted.size() - 1);
    return sorted[lower] + (h - double(lower)) * (sorted[upper] - sorted[lower]);
}

double median(std::span<const double> values) { return quantileOfSorted(sortedCopy(values), 0.5); }

Quartiles quartiles(std::span<const double> values) {
    const auto sorted = sortedCopy(values);
    return {quantileOfSorted(sorted, 0.25), quantileOfSorted(sorted, 0.5), quantileOfSorted(sorted, 0.75)};
}

Interval bootstrapMedian(std::span<const double> blockValues, uint64_t seed, double confidence, int resamples) {
    assert(!blockValues.empty() && resamples > 0);
    constexpr uint64_t kPurpose = 0x626f'6f74;  // keeps these numbers apart from the sampler's
    const auto sorted = sortedCopy(blockValues);
    const auto n = sorted.size();
    std::vector<double> medians(static_cast<size_t>(resamples));
    std::vector<size_t> draws(n);  // how often each value was drawn: counting is much cheaper than sorting
    for (size_t r = 0; r < medians.size(); ++r) {
        const base::Random random(seed, r, kPurpose);
        std::fill(draws.begin(), draws.end(), 0);
        for (size_t i = 0; i < n; ++i) ++draws[((random.bits(i) >> 32) * n) >> 32];
        size_t lower = 0, drawn = draws[0];
        while (drawn < (n + 1) / 2) drawn += draws[++lower];
        size_t upper = lower;
        while (drawn < n / 2 + 1) drawn += draws[++upper];
        medians[r] = (sorted[lower] + sorted[upper]) / 2;
    }
    std::sort(medians.begin(), medians.end());
    const double tail = (1 - confidence) / 2;
    return {quantileOfSorted(medians, tail), quantileOfSorted(medians, 1 - tail)};
}

double autocorrelation(std::span<const double> valuesInTime) {
    const std::vector<double> sorted = sortedCopy(valuesInTime);
    const auto n = double(sorted.size());
    std::vector<double> ranks;  // about their mean; equal values share theirs
    for (const double v : valuesInTime) {
        const auto [lo, hi] = std::equal_range(sorted.begin(), sorted.end(), v);
        ranks.push_back(double((lo - sorted.begin()) + (hi - sorted.begin()) - 1) / 2 - (n - 1) / 2);
    }
    double products = 0, squares = 0;
    for (size_t i = 0; i < ranks.size(); ++i) {
        squares += ranks[i] * ranks[i];
        if (i > 0) products += ranks[i] * ranks[i - 1];
    }
    if (squares == 0) return 0;
    const double rho = products / squares;
    return std::clamp(rho + (1 + 4 * rho) / n, 0.0, 0.9);
}

Interval intervalOfMedian(std::span<const double> valuesInTime, uint64_t seed) {
    constexpr double kNormal = 1.959964;  // 97.5 % quantile
    const double rho = autocorrelation(valuesInTime), inflation = (1 + rho) / (1 - rho);
    const double freedom = std::max(5.0, double(valuesInTime.size()) / inflation) - 1;
    // Student's t by its Cornish-Fisher expansion (Abramowitz & Stegun 26.7.5): 0.3 % off at 4 degrees of freedom, less above.
    const double z = kNormal, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
    const double t = z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom) +
                     (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * freedom * freedom * freedom);
    const double centre = median(valuesInTime), widened = std::sqrt(inflation) * t / kNormal;
    const Interval independent = bootstrapMedian(valuesInTime, seed);
    const double lo = centre - widened * (centre - independent.lo);
    const bool negative = std::any_of(valuesInTime.begin(), valuesInTime.end(), [](double v) { return v < 0; });
    return {negative ? lo : std::max(lo, 0.0), centre + widened * (independent.hi - centre)};
}

double relativeHalfWidth(const Interval& interval, double centre) {
    const double halfWidth = (interval.hi - interval.lo) / 2;
    return halfWidth == 0 ? 0 : halfWidth / std::abs(centre);
}

std::vector<Outlier> tukeyOutliers(std::span<const double> values) {
    if (values.empty()) return {};
    const auto [q1, middle, q3] = quartiles(values);
    const double range = q3 - q1;
    std::vector<Outlier> outliers;
    for (double v : values) {
        const double beyond = std::max(q1 - v, v - q3);
        outliers.push_back(beyond > 3 * range     ? Outlier::far
                           : beyond > 1.5 * range ? Outlier::mild
                                                  : Outlier::none);
    }
    return outliers;
}

std::vector<double> logRatios(std::span<const double> a, std::span<const double> b) {
    assert(a.size() == b.size());
    std::vector<double> ratios;
    for (size_t i = 0; i < a.size(); ++i) ratios.push_back(std::log(a[i] / b[i]));
    return ratios;
}

std::optional<Ratio> ratioOf(std::span<const double> logRatios, uint64_t seed) {
    if (logRatios.size() < kMinBlocksForInterval) return {};
    const auto ci = intervalOfMedian(logRatios, seed);
    return Ratio{std::exp(median(logRatios)), {std::exp(ci.lo), std::exp(ci.hi)}, logRatios.size()};
}

double risingTrendScore(std::span<const double> valuesInTime) {
    const auto n = valuesInTime.size();
    if (n < 4) return 0;
    long s = 0;
    for (size_t i = 0; i < n; ++i)
        for (size_t j = i + 1; j < n; ++j)
            s += (valuesInTime[j] > valuesInTime[i]) - (valuesInTime[j] < valuesInTime[i]);
    const double variance = double(n) * double(n - 1) * double(2 * n + 5) / 18;
    const long corrected = s > 0 ? s - 1 : s < 0 ? s + 1 : 0;
    return double(corrected) / std::sqrt(variance);
}

Summary summarise(std::span<const std::vector<double>> blocks, uint64_t seed) {
    std::vector<double> all, blockMedians;
    for (const auto& block : blocks) {
        if (block.empty()) continue;
        all.insert(all.end(), block.begin(), block.end());
        blockMedians.push_back(median(block));
    }
    Summary summary;
    summary.n = all.size();
    summary.blocks = blockMedians.size();
    if (all.empty()) return summary;
    std::sort(all.begin(), all.end());
    summary.median = median(blockMedians);
    if (blockMedians.size() >= kMinBlocksForInterval) summary.ci = intervalOfMedian(blockMedians, seed);
    summary.q1 = quantileOfSorted(all, 0.25);
    summary.q3 = quantileOfSorted(all, 0.75);
    summary.min = all.front();
    summary.max = all.back();
    return summary;
}

}  // namespace dapple::measure
