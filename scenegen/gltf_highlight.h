#pragma once

#include <algorithm>
#include <cmath>

/// Blinn-Phong highlights as glTF's materials: writeGlb() and the reader must agree.
namespace dapple::scenegen {

/// Roughness of a Blinn-Phong exponent, and back (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces").
inline double roughnessOf(float shininess) { return std::sqrt(2 / (double(shininess) + 2)); }
inline float shininessOf(double roughness) { return float(std::clamp(2 / std::max(roughness * roughness, 1e-6) - 2, 0.0, 1024.0)); }

/// Strength of the highlight whose peak is that of a microfacet lobe of KHR_materials_specular's strength 1: F0 · (exponent + 2) / 8,
/// where F0 = 0.04.
inline double highlightScale(float shininess) { return 0.04 * (double(shininess) + 2) / 8; }

}  // namespace dapple::scenegen
