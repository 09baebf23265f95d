#pragma once

#include "base/image.h"

namespace dapple::scenegen {

/// Samples of a height map (one channel) that were not measured: NaN, infinite, beyond 1e20 (as 3.4e38 is), or at one
/// of the marks -9999, -32768, -32767, -99999, -999999. A mark within a hundredth of which other samples lie is a height.
std::vector<bool> holesOf(const base::ImageF& heights);

/// Fills holes smoothly from their surroundings: the membrane spanned by the samples around them (Laplace's equation,
/// relaxed from coarse to fine). Steps in proportion to the samples; at least one sample is no hole.
void fillHoles(base::ImageF& heights, const std::vector<bool>& holes);

}  // namespace dapple::scenegen
