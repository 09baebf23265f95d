#pragma once

#include "base/image.h"
#include "frame/camera.h"
#include "truth/reference.h"

#include <span>

/// False-colour pictures of a frame's images, rows from the top.
namespace dapple::frame {

/// 0 black … 1 white.
base::Image8 paintVisibility(std::span<const float> visibility, int width, int height);
/// Lit white, shadowed black, between them what translucent casters let through; ambiguous magenta, excluded slate.
base::Image8 paintReference(const truth::Reference& reference);
/// Fragments per pixel, black (none) through violet, orange to pale yellow (32 and more), logarithmic.
base::Image8 paintOverdraw(const base::ImageF& counts);
/// Over a faded, dimmed picture: candidate pixels (in at least one volume) lit green, in shadow red (Buntin & Stamminger
/// 2007, fig. 4). Green is the lighter of the two, so that the picture reads without colour vision.
base::Image8 paintCandidates(const base::Image8& shaded, const base::ImageF& volumes, std::span<const float> visibility);
/// Distance along the view, near light, far dark, logarithmic; sky black.
base::Image8 paintDepth(const base::ImageF& depth, const Camera& camera);
/// Unit normals, three channels: −1 … 1 as 0 … 255; sky black.
base::Image8 paintNormals(const base::ImageF& normals);
/// What a light's view shows: nothing, …
enum class LightViewClass { nothing, receiver, leftOut, drawn, contributing };
struct LightView {
    base::ImageF depth;                   ///< of the nearest caster; 1: none
    std::vector<LightViewClass> classes;  ///< by pixel
};
/// Side by side in a grid: casters left out grey, drawn ones orange, those of them that darken a pixel in sight blue, receivers in
/// sight (that no caster covers) pale yellow.
base::Image8 paintLightViews(std::span<const LightView> views);
/// Maps side by side in a grid, faded; where a mask is set, yellow.
base::Image8 paintMasks(std::span<const base::ImageF> maps, std::span<const base::ImageF> masks);
/// Layers of a light map side by side in a grid, near the sun light, empty dark blue; at most 2048 pixels across.
base::Image8 paintMap(std::span<const base::ImageF> layers);

}  // namespace dapple::frame
