#pragma once

#include "truth/reference.h"

#include <optional>
#include <span>
#include <vector>

namespace dapple::truth {

/// Error of a visibility image V against the reference G, over the valid set Ω = {lit, shadowed}.
/// V and G are thresholded at ½ (lit from ½ on) for all but meanAbsolute; a V that is not finite is wholly wrong.
/// Shares are of |Ω| unless stated; 0 when Ω is empty. The boundary of an image is the pixels of Ω with a
/// 4-neighbour in Ω of the other class: an excluded or ambiguous neighbour makes no edge.
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
    /// Distances between the boundaries of V and G, both ways pooled, pixels; P95 by nearest rank. Empty when either has no boundary:
    /// then falseLight (a missing shadow) or falseShadow says what is wrong.
    std::optional<double> edgeMean, edgeP95, edgeMax;
};

/// V − G of a pixel of Ω: what meanAbsolute is the mean of. ±1 for a V that is not finite.
float difference(const Reference& reference, size_t pixel, float visibility);

/// `visibility`: width · height of the reference, rows from the top, 0 = shadow, 1 = lit.
ErrorMetrics measureError(const Reference& reference, std::span<const float> visibility);

/// Change of an image from one frame to the next, means over the pixels that are in Ω in both frames; 0 without any.
struct Flips {
    double image = 0;      ///< mean |V − V before|, not thresholded
    double reference = 0;  ///< the same of G
    /// Popping: what the image changes more than the truth does. Below 0 where it lags behind.
    double excess() const { return image - reference; }
};
/// `same`: by pixel of now, the pixel of before that it is compared with, −1: none. Empty: the camera stood still.
Flips measureFlips(const Reference& before, const Reference& now, std::span<const float> visibilityBefore, std::span<const float> visibility,
                   std::span<const int32_t> same = {});

/// Pixels of two frames that show the same surface, for measureFlips(): for each pixel of `now`, the one of `before` nearest to
/// where its receiver was seen, if that shows a receiver in the same plane, to a pixel's breadth, facing the same way within
/// 25 degrees; else −1. Half a pixel lies between the two points at most, in both the image and the truth.
/// `clipBefore`: from metres relative to the eye that was; `moved`: from that eye to the present one, metres.
std::vector<int32_t> correspondence(const Receivers& before, const glm::dmat4& clipBefore, const Receivers& now, const glm::dvec3& moved);

/// Error of the truth itself half a pixel away, a share: G against the same view traced through points half a pixel beside
/// the pixels' centres. `shifted`: one reference per direction; the result is the mean over them. Pixels in Ω of both count;
/// 0 without any.
double halfPixelSensitivity(const Reference& reference, std::span<const Reference> shifted);

/// Exact Euclidean distance transform (Felzenszwalb & Huttenlocher 2012): for each pixel the distance in
/// pixels to the nearest set pixel of `mask`; infinity when none is set.
std::vector<float> distanceTransform(std::span<const uint8_t> mask, int width, int height);

}  // namespace dapple::truth
