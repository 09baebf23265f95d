#pragma once

#include "scenegen/plants/species.h"
#include "scenegen/scene.h"

namespace dapple::scenegen {

enum class LeafMode {
    polygon,  ///< the outline of each leaf, folded along its midrib; opaque, open
    card,     ///< alpha-tested quads, each a cluster of leaves
    solid,    ///< the polygon's leaf with a thickness: closed, so that the whole tree is
};

/// Vertices and triangles of one leaf or card.
size_t leafVertices(LeafShape shape, LeafMode mode);
size_t leafTriangles(LeafShape shape, LeafMode mode);

struct Blade {
    glm::dvec3 root, along, across, normal;  ///< a right-handed frame: across × along = normal
    double length, width;                    ///< metres
};

/// Writes a leaf's vertices, indices and, for a card, texture coordinates from those places of a mesh on, which has room for
/// them; its vertices will have numbers that are `shift` higher. A polygon's vertices come piece by piece (the shape `three` has three), from its root counter-clockwise; a solid's
/// are those of its upper side and a point over their middle, then the same of its lower side.
void setLeaf(Mesh& mesh, LeafShape shape, LeafMode mode, size_t vertex, size_t firstIndex, uint32_t shift, const Blade& blade);

}  // namespace dapple::scenegen
