#include "scenegen/lod/half_edges.h"

#include "base/hash.h"

#include <bit>

namespace dapple::scenegen {
namespace {

/// OpenMesh reports a refused face on its error stream; here the count says it.
class MuteOpenMesh {
public:
    MuteOpenMesh() { omerr().disable(); }
    ~MuteOpenMesh() { omerr().enable(); }
};

}  // namespace

std::vector<uint32_t> weldedVertices(const std::vector<glm::vec3>& positions) {
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> first(positions.size()), slots(std::bit_ceil(2 * positions.size() + 1), kNone);
    for (uint32_t i = 0; i < positions.size(); ++i) {
        const glm::vec3 p = positions[i] + 0.0f;  // both zeros are one place
        const uint64_t low = uint64_t(std::bit_cast<uint32_t>(p.x)) << 32 | std::bit_cast<uint32_t>(p.y);
        size_t slot = base::mix64(base::mix64(low) ^ std::bit_cast<uint32_t>(p.z)) & (slots.size() - 1);
        while (slots[slot] != kNone && positions[slots[slot]] != p) slot = (slot + 1) & (slots.size() - 1);
        if (slots[slot] == kNone) slots[slot] = i;
        first[i] = slots[slot];
    }
    return first;
}

HalfEdges toHalfEdges(const Mesh& mesh, size_t& refused) {
    const MuteOpenMesh mute;
    const std::vector<uint32_t> first = weldedVertices(mesh.positions);
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
