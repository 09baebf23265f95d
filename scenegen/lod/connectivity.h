#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

/// What a mesh is as a surface. Vertices at bitwise equal positions count as one: a flat-shaded box has 24 vertices
/// but is a closed surface of 8.
struct Connectivity {
    size_t triangles = 0;
    size_t degenerate = 0;   ///< triangles without area, or with two equal corners
    size_t nonManifold = 0;  ///< triangles that OpenMesh refuses: a third face on an edge, or one turned round
    size_t boundary = 0;     ///< edges with one triangle
    size_t components = 0;
    bool oriented = false;   ///< no edge is run through twice in one direction
    bool spheres = false;    ///< every component has Euler characteristic 2

    bool closed() const { return triangles > 0 && oriented && degenerate == 0 && nonManifold == 0 && boundary == 0; }
};

Connectivity connectivity(const Mesh& mesh);

/// Every directed edge once and its opposite once, on positions welded where they are equal. Linear in the triangles.
/// Solids that touch at a corner are closed here, while connectivity() calls that corner no manifold.
bool isClosed(const Mesh& mesh);

/// True if every mesh is closed and has no triangle without area: what Prototype::closed says.
bool isClosed(const Prototype& prototype);

}  // namespace dapple::scenegen
