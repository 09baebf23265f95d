#include "scenegen/lod/half_edges.h"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <tuple>

namespace dapple::scenegen {
namespace {

/// OpenMesh reports a refused face on its error stream; here the count says it.
class MuteOpenMesh {
public:
    MuteOpenMesh() { omerr().disable(); }
    ~MuteOpenMesh() { omerr().enable(); }
};

/// For each vertex the first one at the same position.
std::vector<uint32_t> weld(const std::vector<glm::vec3>& positions) {
    std::vector<uint32_t> order(positions.size()), first(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) { return std::tuple(positions[i].x, positions[i].y, positions[i].z, i); };
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
    for (size_t k = 0; k < order.size(); ++k) {
        const bool same = k > 0 && positions[order[k]] == positions[order[k - 1]];
        first[order[k]] = same ? first[order[k - 1]] : order[k];
    }
    return first;
}

}  // namespace

HalfEdges toHalfEdges(const Mesh& mesh, size_t& refused) {
    const MuteOpenMesh mute;
    const std::vector<uint32_t> first = weld(mesh.positions);
    HalfEdges surface;
    surface.reserve(mesh.positions.size(), mesh.indices.size() / 2, mesh.triangles());
    std::vector<OpenMesh::VertexHandle> handle(mesh.positions.size());
    for (size_t i = 0; i < handle.size(); ++i) {
        const glm::dvec3 p = mesh.positions[i];
        handle[i] = first[i] == i ? surface.add_vertex({p.x, p.y, p.z}) : handle[first[i]];
    }
    refused = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const auto a = handle[first[mesh.indices[i]]], b = handle[first[mesh.indices[i + 1]]], c = handle[first[mesh.indices[i + 2]]];
        if (a == b || b == c || c == a || !surface.add_face(a, b, c).is_valid()) ++refused;
    }
    return surface;
}

}  // namespace dapple::scenegen
