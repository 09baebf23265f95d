#pragma once

#include "truth/reference.h"

#include <optional>
#include <span>

namespace dapple::truth {

/// Error of a visibility image V against the reference G, over the valid set Ω = {lit, shadowed}.
/// V is thresholded at ½ for all but meanAbsolute. Shares are of |Ω| unless stated; 0 when Ω is empty.
struct ErrorMetrics {
    double error = 0;                ///< falseShadow + falseLight: the figure of the work-precision diagram
    double falseShadow = 0;          ///< V dark, G lit
    double falseShadowBoundary = 0;  ///< … within 2 px (Euclidean) of G's boundary
    double falseShadowInterior = 0;  ///< … farther: acne
    double falseLight = 0;           ///< V lit, G dark
    double falseLightBoundary = 0;
    double falseLightInterior = 0;   ///< … farther: leak
    double meanAbsolute = 0;         ///< mean |V − G|
    double valid = 0;                ///< |Ω| / pixels
    double ambiguous = 0;            ///< ambiguous / (|Ω| + ambiguous)
    double shadowed = 0;             ///< G dark / |Ω|
    /// Distances between the boundaries of V and G, both ways, pixels. Empty when either has no boundary:
    /// then falseLight (a missing shadow) or falseShadow says what is wrong.
    std::optional<double> edgeMean, edgeP95, edgeMax;
};

/// `visibility`: width · height of the reference, rows from the top, 0 = shadow, 1 = lit.
ErrorMetrics measureError(const Reference& reference, std::span<const float> visibility);

/// Reference floor: the error that a perfect technique would still be charged, because the reference
/// itself moves when its samples move by half a pixel; 0 for an image without boundary.
/// Measured, not assumed: share of Ω whose label differs from the 4-neighbour majority's re-tracing is
/// not available here, so the floor is the share of ambiguous pixels, at least one pixel of Ω.
double referenceFloor(const Reference& reference);

/// Exact Euclidean distance transform (Felzenszwalb & Huttenlocher 2012): for each pixel the distance in
/// pixels to the nearest set pixel of `mask`; infinity when none is set.
std::vector<float> distanceTransform(std::span<const uint8_t> mask, int width, int height);

}  // namespace dapple::truth
