#pragma once

#include "base/math.h"

#include <vector>

namespace dapple::visibility {

/// What culling needs of a view, be it a camera's or a light's. "Relative": metres relative to `eye`, world axes.
struct CullView {
    glm::dvec3 eye{0};                ///< metres from Scene::origin
    glm::dmat4 clipFromRelative{1};   ///< clip z in [0, w]
    /// What the view sees lies inside all of them: dot(plane.xyz, p) + plane.w ≥ 0, unit normals, relative. Callers may append
    /// planes of their own, for example those of the receivers that a light's view serves.
    std::vector<glm::dvec4> planes;
    bool parallel = false;            ///< a sun's view: rays along `axis`, whatever the matrix makes of them
    glm::dvec3 axis{0};               ///< unit: parallel to the image plane's normal (camera), along the rays (sun)
    double near = 0;                  ///< metres before the eye (camera only)

    /// A camera, z reversed or not. `near`: metres. The planes are the six of the matrix.
    static CullView camera(const glm::dvec3& eye, const glm::dmat4& clipFromRelative, double near);
    /// A sun's map, orthographic or warped, drawn with depth clamp: z grows along `direction` (unit, in which the light
    /// travels) and what lies beyond z = w cannot darken what the map serves. The planes are the four sides and that one.
    static CullView sun(const glm::dvec3& eye, const glm::dmat4& clipFromRelative, const glm::dvec3& direction);

    base::DBox relative(const base::Box& box) const { return {glm::dvec3(box.lo) - eye, glm::dvec3(box.hi) - eye}; }
    /// False only if the box lies wholly outside one plane. Empty boxes are nowhere.
    bool mayContain(const base::DBox& relativeBox) const;
    /// Front-to-back key, metres: of the nearest point of the box, its distance from the eye or along the sun's rays.
    double key(const base::DBox& relativeBox) const;
    /// Whether the box must be taken for visible without a query: a part of it is not safely before the view (w ≤ 0 or nearly
    /// so), or, in a camera's view, it holds the eye when enlarged by the near plane's distance or it reaches the near plane.
    bool certainlyVisible(const base::DBox& relativeBox) const;
    /// Metres across the rays that one pixel of a `width` × `height` raster spans at most anywhere in the box. Only for boxes
    /// that are not certainlyVisible().
    double footprint(const base::DBox& relativeBox, int width, int height) const;
};

}  // namespace dapple::visibility
