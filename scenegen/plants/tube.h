#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace dapple::scenegen {

/// Branches evaluated together: with the branch as the innermost index, every stencil weight is loaded once
/// for all of them and the arithmetic fills whole SIMD registers.
inline constexpr int kLanes = 16;

/// A closed tube: `rings` rings of `sides` (even) control points, control point = ring · sides + side, both ends
/// capped by quads; subdivided `refine` times by Catmull-Clark. All branches of one topology share the table.
struct TubeTopology {
    /// One control point's share of a refined vertex: limit position and its two tangents.
    struct Weight {
        uint32_t control;
        float position, tangentU, tangentV;
    };
    int sides = 0, rings = 0, refine = 0;
    std::vector<Weight> weights;    ///< of vertex v: [first[v], first[v + 1])
    std::vector<uint32_t> first;
    std::vector<uint32_t> indices;  ///< triangles, outward, in an order that suits a small vertex cache

    uint32_t controls() const { return uint32_t(sides * rings); }
    uint32_t vertices() const { return uint32_t(first.size()) - 1; }
};

/// From a cache of the whole program (thread-safe); lives for ever. Built once by sending an identity basis
/// through OpenSubdiv's refinement and limit masks, so positions and normals are those of the limit surface.
const TubeTopology& tubeTopology(int sides, int rings, int refine);

/// Triangles of such a tube, without building it.
size_t tubeTriangles(int sides, int rings, int refine);

/// Cage radius over surface radius: the limit of a ring lies inside its polygon.
double cageScale(int sides);

/// Limit positions and unit normals of up to kLanes tubes. `controls`: [control][xyz][lane], metres.
/// Tube i < lanes writes vertices() elements at positions + i · vertices(), and normals likewise.
void evaluateTubes(const TubeTopology& topology, const float* controls, int lanes, glm::vec3* positions, glm::vec3* normals);

}  // namespace dapple::scenegen
