#include "measure/counters.h"

#include "base/error.h"
#include "base/random.h"
#include "measure/counters/ledger.h"
#include "measure/counters/overdraw.h"
#include "measure/counters/pipeline.h"
#include "measure/flags.h"
#include "measure/timers/gpu_queries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace dapple::measure {
namespace {

TEST(Overdraw, BinsEveryPixelOnce) {
    const std::vector<float> counts{0, 0, 1, 2, 3, 4, 5, 8, 9, 16, 17, 1000};
    const auto h = overdrawHistogram(counts);
    EXPECT_EQ(h.pixels, (std::array<uint64_t, kOverdrawBins>{2, 1, 1, 2, 2, 2, 2}));
    EXPECT_EQ(h.max, 1000u);
    EXPECT_DOUBLE_EQ(h.mean, 1065.0 / 12);
    EXPECT_EQ(overdrawHistogram({}).max, 0u);
    EXPECT_EQ(overdrawHistogram({}).mean, 0);
}

TEST(Overdraw, MatchesBruteForce) {
    constexpr std::array<double, kOverdrawBins> kUpper{0, 1, 2, 4, 8, 16, 1e30};
    const base::Random random(1, 0, 0);
    std::vector<float> counts;
    std::array<uint64_t, kOverdrawBins> expected{};
    for (uint64_t i = 0; i < 5000; ++i) {
        counts.push_back(std::floor(std::exp2(random.uniform(i, 0, 7)) - 1));
        size_t bin = 0;
        while (double(counts.back()) > kUpper[bin]) ++bin;
        ++expected[bin];
    }
    EXPECT_EQ(overdrawHistogram(counts).pixels, expected);
}

TEST(Overdraw, RefusesADamagedImage) {
    EXPECT_THROW(overdrawHistogram(std::vector<float>{1, -1}), base::Error);
    EXPECT_THROW(overdrawHistogram(std::vector<float>{NAN}), base::Error);
    EXPECT_THROW(overdrawHistogram(std::vector<float>{INFINITY}), base::Error);
}

TEST(Ledger, AddsUp) {
    Ledger shadow, frame;
    shadow.drawCalls = 1;
    shadow.trianglesSubmitted = 36000 * 105;
    shadow.texelsWritten = 4194304;
    frame.drawCalls = 2;
    frame.trianglesSubmitted = 2;
    frame += shadow;
    EXPECT_EQ(frame.drawCalls, 3u);
    EXPECT_EQ(frame.trianglesSubmitted, 36000u * 105 + 2);
    EXPECT_EQ(frame.texelsWritten, 4194304u);
}

TEST(Registry, NamesAreUniqueAndDescribed) {
    std::set<std::string_view> names;
    for (const MetricInfo& info : metrics()) {
        EXPECT_TRUE(names.insert(info.name).second) << info.name;
        EXPECT_FALSE(info.description.empty()) << info.name;
        EXPECT_EQ(info.name.find(','), std::string_view::npos);
        EXPECT_EQ(&metricInfo(info.name), &info);
        EXPECT_EQ(betterName(info.better), info.better == Better::lower    ? "lower"
                                           : info.better == Better::higher ? "higher"
                                                                           : "none");
    }
    for (const char* of : {"geometry_overdraw_", "volume_overdraw_"})
        for (auto bin : kOverdrawBinNames) EXPECT_TRUE(names.contains(of + std::string(bin))) << bin;
    try {
        metricInfo("fram_time");
        FAIL();
    } catch (const base::UsageError& e) {
        EXPECT_NE(std::string(e.what()).find("frame_time"), std::string::npos);
    }
}

TEST(PassCounters, MissingIsNotZero) {
    PassCounters pass{"shade",
                      {{metric::kSamplesPassed, 100, ""}, {metric::kFragmentInvocations, {}, "no extension"}}};
    EXPECT_EQ(pass.value(metric::kSamplesPassed), 100u);
    EXPECT_FALSE(pass.value(metric::kFragmentInvocations));
    EXPECT_FALSE(pass.overshade());
    pass.values[1] = {metric::kFragmentInvocations, 160, ""};
    EXPECT_DOUBLE_EQ(pass.overshade().value(), 1.6);
    pass.values[0].value = 0;
    EXPECT_FALSE(pass.overshade());
}

TEST(Flags, JoinWithoutDuplicates) {
    Flags flags;
    EXPECT_EQ(joinFlags(flags), "");
    addFlag(flags, flag::kNoisy);
    addFlag(flags, flag::kOutlier);
    addFlag(flags, flag::kNoisy);
    EXPECT_EQ(joinFlags(flags), "noisy;outlier");
    EXPECT_TRUE(isValidSample(flags));
    for (const FlagInfo& info : kFlags) EXPECT_EQ(isValidSample({std::string(info.name)}), !info.invalidatesSample);
}

TEST(CounterDifference, WrapsAtTheCountersWidth) {
    bool wrapped = true;
    EXPECT_EQ(counterDifference(100, 250, 64, wrapped), 150u);
    EXPECT_FALSE(wrapped);
    EXPECT_EQ(counterDifference(0x3fff'fff0, 0x10, 30, wrapped), 0x20u);
    EXPECT_TRUE(wrapped);
    EXPECT_EQ(counterDifference(~uint64_t{0}, 4, 64, wrapped), 5u);
    EXPECT_TRUE(wrapped);
}

}  // namespace
}  // namespace dapple::measure
