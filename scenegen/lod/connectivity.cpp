#include "scenegen/lod/connectivity.h"

#include "base/hash.h"
#include "scenegen/lod/half_edges.h"

#include <bit>

namespace dapple::scenegen {
namespace {

size_t degenerateTriangles(const Mesh& mesh) {
    size_t count = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]], c = mesh.positions[mesh.indices[i + 2]];
        const glm::dvec3 cross = glm::cross(b - a, c - a);
        const double longest = std::max({glm::dot(b - a, b - a), glm::dot(c - a, c - a), glm::dot(c - b, c - b)});
        // Relative, as a needle's triangles are tiny: height below 1e-6 of the longest edge.
        count += !(glm::dot(cross, cross) > 1e-12 * longest * longest);
    }
    return count;
}

}  // namespace

Connectivity connectivity(const Mesh& mesh) {
    Connectivity c;
    c.triangles = mesh.triangles();
    c.degenerate = degenerateTriangles(mesh);
    HalfEdges surface = toHalfEdges(mesh, c.nonManifold);
    c.oriented = c.nonManifold == 0;
    for (const auto edge : surface.edges()) c.boundary += surface.is_boundary(edge);

    // Euler characteristic per component: V - E + F, by flood over faces that share a vertex.
    std::vector<int> component(surface.n_vertices(), -1);
    std::vector<long> euler;
    std::vector<OpenMesh::VertexHandle> front;
    for (const auto seed : surface.vertices()) {
        if (component[size_t(seed.idx())] >= 0 || surface.is_isolated(seed)) continue;
        const int id = int(euler.size());
        euler.push_back(0);
        component[size_t(seed.idx())] = id;
        front.push_back(seed);
        while (!front.empty()) {
            const OpenMesh::VertexHandle v = front.back();
            front.pop_back();
            for (const auto n : surface.vv_range(v))
                if (component[size_t(n.idx())] < 0) {
                    component[size_t(n.idx())] = id;
                    front.push_back(n);
                }
        }
    }
    const auto of = [&](OpenMesh::VertexHandle v) -> long& { return euler[size_t(component[size_t(v.idx())])]; };
    for (const auto v : surface.vertices())
        if (!surface.is_isolated(v)) ++of(v);
    for (const auto e : surface.edges()) --of(surface.to_vertex_handle(surface.halfedge_handle(e, 0)));
    for (const auto f : surface.faces()) ++of(*surface.cfv_iter(f));
    c.components = euler.size();
    c.spheres = c.components > 0;
    for (const long x : euler) c.spheres = c.spheres && x == 2;
    return c;
}

bool isClosed(const Mesh& mesh) {
    if (mesh.indices.empty()) return false;
    const std::vector<uint32_t> welded = weldedVertices(mesh.positions);
    // Open addressing over edges, each as its lower and higher vertex; the two topmost bits of these say in which
    // direction a triangle has run through it. A closed mesh has an edge for two indices: half full at most.
    constexpr uint64_t kUpwards = uint64_t{1} << 63, kDownwards = uint64_t{1} << 31, kBoth = kUpwards | kDownwards;
    std::vector<uint64_t> edges(std::bit_ceil(mesh.indices.size() + 1));
    size_t unpaired = 0, count = 0;
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        const uint64_t a = welded[mesh.indices[i]], b = welded[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
        if (a == b) return false;
        const uint64_t edge = std::min(a, b) << 32 | std::max(a, b), direction = a < b ? kUpwards : kDownwards;
        size_t slot = base::mix64(edge) & (edges.size() - 1);
        while (edges[slot] != 0 && (edges[slot] & ~kBoth) != edge) slot = (slot + 1) & (edges.size() - 1);
        if (edges[slot] == 0) {
            if (++count > mesh.indices.size() / 2) return false;
            edges[slot] = edge | direction, ++unpaired;
        } else {
            if (edges[slot] & direction) return false;
            edges[slot] |= direction, --unpaired;
        }
    }
    return unpaired == 0;
}

bool isClosed(const Prototype& prototype) {
    for (const Mesh& mesh : prototype.meshes)
        if (!isClosed(mesh) || degenerateTriangles(mesh) > 0) return false;
    return !prototype.meshes.empty();
}

}  // namespace dapple::scenegen
