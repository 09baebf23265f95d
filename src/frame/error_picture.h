#pragma once

#include "base/image.h"
#include "truth/reference.h"

#include <span>

namespace dapple::frame {

/// Where a technique errs, to be read on a slide: over a light grey picture, dots of at least 2 × 2 pixels for false shadow
/// (red), false light (blue) and ambiguous pixels (magenta); beside it the ray-traced truth; below both a legend with shares.
/// `shaded`: RGB, of the reference's size. `visibility`: per pixel, 0 dark … 1 lit. The result is wider and higher.
base::Image8 paintErrorSheet(const base::Image8& shaded, const truth::Reference& reference, std::span<const float> visibility);

}  // namespace dapple::frame
