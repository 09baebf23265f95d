#include "scenegen/lod/decimate.h"

#include "scenegen/lod/connectivity.h"
#include "scenegen/lod/half_edges.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wshadow"
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#pragma GCC diagnostic pop

#include <algorithm>
#include <numeric>

namespace dapple::scenegen {
namespace {

Mesh decimateClosed(const Mesh& mesh, double keep) {
    size_t refused = 0;
    HalfEdges surface = toHalfEdges(mesh, refused);
    surface.request_vertex_status();
    surface.request_edge_status();
    surface.request_face_status();
    surface.request_face_normals();
    surface.request_vertex_normals();
    surface.update_face_normals();

    OpenMesh::Decimater::DecimaterT<HalfEdges> decimater(surface);
    OpenMesh::Decimater::ModQuadricT<HalfEdges>::Handle quadric;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();  // makes it the one that sets the order
    OpenMesh::Decimater::ModNormalFlippingT<HalfEdges>::Handle flipping;
    decimater.add(flipping);
    decimater.initialize();
    decimater.decimate_to_faces(0, size_t(keep * double(mesh.triangles())));
    surface.garbage_collection();
    surface.update_normals();

    Mesh result;
    result.material = mesh.material;
    for (const auto v : surface.vertices()) {
        const auto p = surface.point(v), n = surface.normal(v);
        result.positions.emplace_back(float(p[0]), float(p[1]), float(p[2]));
        result.normals.push_back(glm::vec3(glm::normalize(glm::dvec3(n[0], n[1], n[2]))));
    }
    for (const auto f : surface.faces())
        for (const auto v : surface.fv_range(f)) result.indices.push_back(uint32_t(v.idx()));
    return result;
}

/// Component of every vertex, by union of the triangles' corners, numbered by first appearance.
std::vector<uint32_t> components(const Mesh& mesh, uint32_t& count) {
    std::vector<uint32_t> parent(mesh.positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
        for (size_t k = 1; k < 3; ++k) {
            const uint32_t a = root(mesh.indices[i]), b = root(mesh.indices[i + k]);
            parent[std::max(a, b)] = std::min(a, b);
        }
    std::vector<uint32_t> number(parent.size());
    count = 0;
    for (uint32_t v = 0; v < parent.size(); ++v) number[v] = root(v) == v ? count++ : number[root(v)];
    return number;
}

/// Component c stays if the running share passes a whole number, which thins evenly.
Mesh thinOpen(const Mesh& mesh, double keep) {
    uint32_t count = 0;
    const std::vector<uint32_t> component = components(mesh, count);
    const auto wanted = size_t(std::max(1.0, keep * count + 0.5));
    const auto stays = [&](uint32_t c) { return (c + 1) * wanted / count != c * wanted / count; };
    const auto growth = float(std::sqrt(double(count) / double(std::min<size_t>(wanted, count))));

    Mesh result;
    result.material = mesh.material;
    std::vector<uint32_t> renumbered(mesh.positions.size(), ~0u), root(count, ~0u);
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const uint32_t c = component[v];
        if (root[c] == ~0u) root[c] = v;  // a leaf's first vertex sits on its twig
        if (!stays(c)) continue;
        renumbered[v] = uint32_t(result.positions.size());
        const glm::vec3 foot = mesh.positions[root[c]];
        result.positions.push_back(foot + (mesh.positions[v] - foot) * growth);
        result.normals.push_back(mesh.normals[v]);
        if (!mesh.uvs.empty()) result.uvs.push_back(mesh.uvs[v]);
    }
    for (const uint32_t i : mesh.indices)
        if (renumbered[i] != ~0u) result.indices.push_back(renumbered[i]);
    return result;
}

}  // namespace

Prototype decimate(const Prototype& prototype, double keep) {
    Prototype result = prototype;
    if (keep >= 1) return result;
    for (Mesh& mesh : result.meshes) mesh = connectivity(mesh).closed() && mesh.uvs.empty() ? decimateClosed(mesh, keep) : thinOpen(mesh, keep);
    result.closed = isClosed(result);
    return result;
}

}  // namespace dapple::scenegen
