#pragma once

#include "base/hash.h"

#include <array>
#include <cstdint>

namespace dapple::base {

/// Counter-based random numbers: each number is a pure function of (seed, object, purpose, index), so
/// that drawing one more here never shifts another one there. No std::*_distribution: their algorithms
/// are implementation-defined, and scenes must be the same bytes from every compiler.
class Random {
public:
    constexpr Random(uint64_t seed, uint64_t object, uint64_t purpose)
        : key_(mix64(mix64(mix64(seed) ^ object) ^ purpose)) {}

    constexpr uint64_t bits(uint64_t index) const { return mix64(key_ ^ (index < kMixed.size() ? kMixed[index] : mix64(index))); }
    /// Uniform in [0, 1), a multiple of 2^-24.
    constexpr float uniform(uint64_t index) const {
        return static_cast<float>(bits(index) >> 40) * 0x1p-24f;
    }
    /// Uniform in [lo, hi]; hi itself only by rounding, and never when lo is 0.
    constexpr float uniform(uint64_t index, float lo, float hi) const { return lo + (hi - lo) * uniform(index); }
    /// Next number of the sequence 0, 1, 2, …; for code that draws in a fixed order.
    constexpr float next() { return uniform(counter_++); }
    constexpr float next(float lo, float hi) { return lo + (hi - lo) * next(); }

private:
    /// Of the indices that most sequences stay within.
    static constexpr auto kMixed = [] {
        std::array<uint64_t, 256> mixed{};
        for (uint64_t i = 0; i < mixed.size(); ++i) mixed[i] = mix64(i);
        return mixed;
    }();
    uint64_t key_;
    uint64_t counter_ = 0;
};

}  // namespace dapple::base
