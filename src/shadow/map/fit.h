#pragma once

#include "frame/camera.h"

#include <span>
#include <string>
#include <vector>

/// Light-space fits of one shadow map. All positions are metres relative to the eye, in double.
namespace dapple::shadow {

/// Orthonormal axes of the map: u to the right, v up, l the direction in which the light travels.
struct LightBasis {
    glm::dvec3 u, v, l;
    glm::dvec3 toLight(const glm::dvec3& p) const { return {glm::dot(p, u), glm::dot(p, v), glm::dot(p, l)}; }
};

/// v follows the projected view direction, unless view and light are parallel within |v · l| ≥ 0.9997: then a
/// fixed basis, so that nothing divides by a vanishing length.
LightBasis lightBasis(const glm::dvec3& light, const glm::dvec3& viewForward);

/// Vertices of frustum slice [near, far] ∩ box: what the map serves. Empty when they do not meet.
std::vector<glm::dvec3> viewBody(const frame::Camera& camera, double near, double far, const base::DBox& sceneBox);

/// The same of slice ∩ the union of `boxes`: what is seen (Mattausch et al. 2011, section 1.4).
std::vector<glm::dvec3> visibleBody(const frame::Camera& camera, double near, double far, std::span<const base::DBox> boxes);

struct LightFit {
    glm::dmat4 clipFromRelative{1};  ///< clip z in [0, 1] over the receivers; casters before it rely on depth clamp
    double maxTexel = 0;             ///< metres: longest side of a texel's footprint across the light, over the body
    double depthRange = 0;           ///< metres along l that clip z 0…1 spans at the body (its longest, under a warp)
    double leastW = 1;               ///< clip w of the body's nearest point to the warp's centre
    bool empty = false;              ///< no receiver can be in view: no map is needed
    std::string fallback;            ///< why a warp was given up; empty otherwise
};

enum class FitKind { scene, frustum, lispsm };

/// `sceneBounds`: light-space bounds of everything, for FitKind::scene. `size`: texels along a side; `padTexels`
/// are added around the window so that a kernel never leaves it.
LightFit fitLight(FitKind kind, const LightBasis& basis, const frame::Camera& camera, const std::vector<glm::dvec3>& body,
                  const base::DBox& sceneBounds, int size, double padTexels);

/// Split distances C_0 … C_k of a practical split: C_i = λ n (f/n)^(i/k) + (1 − λ)(n + (i/k)(f − n)) (Zhang et al.
/// 2006). `near` is raised to far · 1e-4, else the first logarithmic split swallows everything.
std::vector<double> practicalSplits(double near, double far, int count, double lambda);

}  // namespace dapple::shadow
