#pragma once

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

private:
    /// A box whose every point has dot(outward, p) > limit cannot reach the body.
    struct Side {
        glm::dvec3 outward;
        double limit;
    };
    std::vector<Side> sides_;
};

}  // namespace dapple::shadow
