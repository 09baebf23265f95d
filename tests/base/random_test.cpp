#include "base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <vector>

namespace dapple::base {
namespace {

// Published outputs of splitmix64 seeded with 1234567 (its state grows by the golden gamma per output).
TEST(Mix64, MatchesSplitmix64) {
    constexpr std::array<uint64_t, 5> kExpected{6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                                                4593380528125082431u, 16408922859458223821u};
    for (size_t i = 0; i < kExpected.size(); ++i) EXPECT_EQ(mix64(1234567 + i * 0x9e3779b97f4a7c15u), kExpected[i]);
}

uint64_t hashOf(std::initializer_list<std::string_view> calls) {
    Hasher hasher;
    for (const std::string_view text : calls) hasher.text(text);
    return hasher.digest();
}

TEST(Hasher, DependsOnEveryByteAndOnTheSplitIntoCalls) {
    EXPECT_EQ(hashOf({"dapple", "shade"}), hashOf({"dapple", "shade"}));
    const std::set<uint64_t> different{hashOf({}),           hashOf({""}),          hashOf({"", ""}),     hashOf({"abc"}),
                                       hashOf({"ab", "c"}),  hashOf({"a", "bc"}),   hashOf({"c", "ab"}),  hashOf({"12345678"}),
                                       hashOf({"1234", "5678"}), hashOf({std::string_view("abc\0", 4)}),
                                       hashOf({std::string_view("\0", 1)}), hashOf({std::string_view("\0\0\0\0\0\0\0\0", 8)})};
    EXPECT_EQ(different.size(), 12u);
}

TEST(Hasher, AvalanchesOverEveryInputBit) {
    std::array<unsigned char, 21> data{};  // two whole words and a tail
    const auto digest = [&] {
        Hasher hasher;
        hasher.bytes(data.data(), data.size());
        return hasher.digest();
    };
    const uint64_t before = digest();
    double flipped = 0;
    for (size_t bit = 0; bit < data.size() * 8; ++bit) {
        data[bit / 8] ^= static_cast<unsigned char>(1u << bit % 8);
        const int distance = std::popcount(before ^ digest());
        data[bit / 8] ^= static_cast<unsigned char>(1u << bit % 8);
        EXPECT_GT(distance, 10) << "bit " << bit;  // 32 ± 4; 10 is 5.5 deviations away
        flipped += distance;
    }
    EXPECT_NEAR(flipped / (21 * 8), 32, 1.6);  // five deviations of the mean
}

TEST(Hasher, ValueAndArrayAreTheirBytes) {
    const std::array<uint32_t, 3> items{1, 2, 3};
    Hasher byBytes, byArray, byValue;
    byBytes.bytes(items.data(), sizeof items);
    byArray.array(std::span<const uint32_t>(items));
    byValue.value(items);
    EXPECT_EQ(byBytes.digest(), byArray.digest());
    EXPECT_EQ(byBytes.digest(), byValue.digest());
}

TEST(Hex16, IsSixteenLowerCaseDigits) {
    EXPECT_EQ(hex16(0), "0000000000000000");
    EXPECT_EQ(hex16(0x0123'4567'89ab'cdefu), "0123456789abcdef");
    EXPECT_EQ(hex16(~uint64_t{0}), "ffffffffffffffff");
}

TEST(Random, IsAPureFunctionOfItsCounter) {
    const Random a(1, 2, 3), b(1, 2, 3);
    std::vector<uint64_t> forwards, backwards(1000);
    for (uint64_t i = 0; i < 1000; ++i) forwards.push_back(a.bits(i));
    for (uint64_t i = 1000; i-- > 0;) backwards[i] = b.bits(i);
    EXPECT_EQ(forwards, backwards);
    EXPECT_EQ(std::set<uint64_t>(forwards.begin(), forwards.end()).size(), forwards.size());

    Random sequence(1, 2, 3);
    for (uint64_t i = 0; i < 100; ++i) {
        EXPECT_EQ(sequence.next(), a.uniform(i));
        static_cast<void>(sequence.bits(i * 7));  // looking elsewhere shifts nothing
    }
    static_assert(Random(1, 2, 3).bits(4) == Random(1, 2, 3).bits(4));
}

TEST(Random, UniformHasTheMomentsOfTheUniformDistribution) {
    constexpr int kCount = 1'000'000, kBins = 64;
    const Random random(2024, 7, 1);
    double sum = 0, squares = 0, neighbours = 0, last = 0.5;
    std::array<int, kBins> bins{};
    for (uint64_t i = 0; i < kCount; ++i) {
        const float u = random.uniform(i);
        ASSERT_GE(u, 0.0f);
        ASSERT_LT(u, 1.0f);
        ASSERT_EQ(std::ldexp(u, 24), std::floor(std::ldexp(u, 24)));
        const double x = u;
        sum += x;
        squares += (x - 0.5) * (x - 0.5);
        neighbours += (x - 0.5) * (last - 0.5);
        last = x;
        ++bins[size_t(x * kBins)];
    }
    // Bounds: five standard deviations of each statistic for a million independent draws.
    EXPECT_NEAR(sum / kCount, 0.5, 5 * std::sqrt(1.0 / 12 / kCount));
    EXPECT_NEAR(squares / kCount, 1.0 / 12, 5 * std::sqrt(1.0 / 180 / kCount));
    EXPECT_NEAR(neighbours / kCount, 0, 5 * (1.0 / 12) / std::sqrt(kCount));
    double chiSquare = 0;
    for (const int n : bins) chiSquare += std::pow(n - double(kCount) / kBins, 2) / (double(kCount) / kBins);
    EXPECT_NEAR(chiSquare, kBins - 1, 5 * std::sqrt(2.0 * (kBins - 1)));
}

TEST(Random, StreamsOfOtherSeedsObjectsAndPurposesAreIndependent) {
    constexpr uint64_t kCount = 100'000;
    const Random base(5, 6, 7);
    for (const Random& other : {Random(4, 6, 7), Random(5, 7, 7), Random(5, 6, 6), Random(6, 5, 7), Random(5, 7, 6), Random(7, 6, 5)}) {
        double flipped = 0, correlation = 0;
        for (uint64_t i = 0; i < kCount; ++i) {
            EXPECT_NE(base.bits(i), other.bits(i));
            flipped += std::popcount(base.bits(i) ^ other.bits(i));
            correlation += (double(base.uniform(i)) - 0.5) * (double(other.uniform(i)) - 0.5);
        }
        EXPECT_NEAR(flipped / kCount, 32, 5 * 4 / std::sqrt(kCount));  // a binomial of 64: deviation 4
        EXPECT_NEAR(correlation / kCount, 0, 5 * (1.0 / 12) / std::sqrt(kCount));
    }
}

// The greatest draw, 1 - 2^-24, comes once in 16 million: find one, and see what rounding makes of it.
TEST(Random, RangesHoldTheirEnds) {
    const Random random(1, 1, 1);
    uint64_t greatest = 0;
    while (greatest < 400'000'000 && random.bits(greatest) >> 40 != 0xffffff) ++greatest;
    ASSERT_EQ(random.uniform(greatest), 1 - 0x1p-24f);
    for (float hi = 1; hi < 100; hi += 0.37f) EXPECT_LT(random.uniform(greatest, 0, hi), hi);  // safe as an index
    EXPECT_LE(random.uniform(greatest, 1, 2), 2.0f);
    for (uint64_t i = 0; i < 100'000; ++i) {
        const float x = random.uniform(i, -3, 5);
        ASSERT_GE(x, -3.0f);
        ASSERT_LE(x, 5.0f);
    }
}

}  // namespace
}  // namespace dapple::base
