#pragma once

#include "scenegen/scene.h"

#include <vector>

namespace dapple::shadow {

/// Closed prototypes as shaders/shadow/volume.vert reads them (std430): from a face's one sign every edge knows whether it
/// is on the silhouette, so that caps and sides close without a crack. Prototype space, metres.
struct Silhouettes {
    struct Face {
        glm::vec4 normal;    ///< unit, outward; w unused
        glm::uvec4 corners;  ///< counter-clockwise from outside; w unused
    };
    /// `left` runs from `from` to `to`, `right` from `to` to `from`.
    struct Edge {
        uint32_t from, to, left, right;
    };
    /// The part of one prototype. A closed surface has three edges to two faces.
    struct Range {
        uint32_t firstFace = 0, faces = 0;
        uint32_t firstEdge() const { return firstFace / 2 * 3; }
        uint32_t edges() const { return faces / 2 * 3; }
    };
    std::vector<glm::vec4> corners;  ///< w unused
    std::vector<Face> faces;
    std::vector<Edge> edges;

    /// Appends a prototype, its triangles' corners in their order. Throws UsageError when it is not closed.
    Range add(const scenegen::Prototype& prototype);
};
static_assert(sizeof(Silhouettes::Face) == 32 && sizeof(Silhouettes::Edge) == 16);

}  // namespace dapple::shadow
