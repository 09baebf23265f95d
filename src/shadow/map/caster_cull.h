#pragma once

#include "gpuscene/hierarchy.h"
#include "shadow/map/fit.h"

namespace dapple::shadow {

/// Convex hull, counter-clockwise: monotone chain (Andrew 1979).
std::vector<glm::dvec2> convexHull(std::vector<glm::dvec2> points);

/// Which casters can darken a body of receivers: a box swept along the light must meet it. Separating axes that the
/// sweep cannot cross: those of the two silhouettes seen from the sun, which is exact there, and the faces of the body
/// and of the box that look along the light. Conservative: edge against edge is left out.
class CasterCull {
public:
    /// `body`: vertices of receivers' convex hull, relative to the eye. `margin`: metres that a kernel and a bias reach.
    CasterCull(const LightBasis& basis, const frame::Camera& camera, const std::vector<glm::dvec3>& body, double margin);
    bool keep(const base::DBox& relativeBox) const;
    /// Appends planes as visibility::CullView has them: what they leave out cannot reach the body.
    void appendPlanes(std::vector<glm::dvec4>& planes) const;
    /// The items of a hierarchy whose boxes it keeps, sorted; whole subtrees at a time are not. `boxes`: by item, as the hierarchy
    /// has them, metres from Scene::origin, as `eye` is.
    std::vector<uint32_t> kept(const gpuscene::Hierarchy& hierarchy, std::span<const base::Box> boxes, const glm::dvec3& eye) const;

private:
    /// A box whose every point has dot(outward, p) > limit cannot reach the body.
    struct Side {
        glm::dvec3 outward;
        double limit;
    };
    std::vector<Side> sides_;
};

}  // namespace dapple::shadow
