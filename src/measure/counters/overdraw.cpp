#include "measure/counters/overdraw.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace dapple::measure {

OverdrawHistogram overdrawHistogram(std::span<const float> counts) {
    OverdrawHistogram histogram;
    uint64_t sum = 0;
    for (float value : counts) {
        if (!std::isfinite(value) || value < 0)
            throw base::Error(base::ExitCode::failed, "overdraw image: a count is not a finite number >= 0");
        const auto count = uint64_t(std::lround(value));
        // Bins end at 0, 1, 2, 4, 8, 16: past 1 that is the bit length of count − 1.
        const auto bin = count < 2 ? count : uint64_t(std::bit_width(count - 1)) + 1;
        ++histogram.pixels[std::min(bin, uint64_t{kOverdrawBins - 1})];
        sum += count;
        histogram.max = std::max(histogram.max, count);
    }
    if (!counts.empty()) histogram.mean = double(sum) / double(counts.size());
    return histogram;
}

}  // namespace dapple::measure
