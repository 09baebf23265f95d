#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace dapple::measure {

inline constexpr size_t kOverdrawBins = 7;
inline constexpr std::array<std::string_view, kOverdrawBins> kOverdrawBinNames{"0",   "1",    "2",  "3-4",
                                                                               "5-8", "9-16", ">16"};

struct OverdrawHistogram {
    std::array<uint64_t, kOverdrawBins> pixels{};  ///< parallel to kOverdrawBinNames; sums to the image's pixels
    double mean = 0;                               ///< fragments per pixel, over all pixels
    uint64_t max = 0;
};

/// `counts`: fragments of each pixel, whole numbers as an additive R32F target holds them (exact to 2^24).
/// Throws base::Error(failed) if one is not finite or negative: the image is damaged.
OverdrawHistogram overdrawHistogram(std::span<const float> counts);

}  // namespace dapple::measure
