#pragma once

#include "scenegen/scene.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wshadow"
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#pragma GCC diagnostic pop

namespace dapple::scenegen {

struct HalfEdgeTraits : OpenMesh::DefaultTraits {
    using Point = OpenMesh::Vec3d;
    using Normal = OpenMesh::Vec3d;
};
using HalfEdges = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;

/// For each vertex the first one at an equal position. Linear.
std::vector<uint32_t> weldedVertices(const std::vector<glm::vec3>& positions);

/// The mesh with vertices of bitwise equal position welded. `refused` counts triangles that would make it
/// non-manifold or that have two equal corners; they are left out.
HalfEdges toHalfEdges(const Mesh& mesh, size_t& refused);

}  // namespace dapple::scenegen
