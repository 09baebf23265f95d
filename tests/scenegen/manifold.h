#pragma once

#include "scenegen/scene.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

/// What is wrong with a mesh that should consist of closed, oriented spheres without shared vertices, or "".
/// By counting: every directed edge once and its opposite once, V - E + F = 2 in every component; linear, because the
/// tests do it to tens of millions of triangles.
inline std::string brokenSpheres(const dapple::scenegen::Mesh& mesh) {
    const size_t vertices = mesh.positions.size();
    const auto corner = [&](size_t i) { return mesh.indices[i]; };
    const auto next = [](size_t i) { return i % 3 == 2 ? i - 2 : i + 1; };
    std::vector<uint32_t> first(vertices + 1, 0), ends(mesh.indices.size());  // of the directed edges, by their start
    for (const uint32_t v : mesh.indices) ++first[v + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<uint32_t> fill(first.begin(), first.end() - 1);
    for (size_t i = 0; i < mesh.indices.size(); ++i) ends[fill[corner(i)]++] = corner(next(i));
    const auto count = [&](uint32_t from, uint32_t to) { return std::count(&ends[first[from]], ends.data() + first[from + 1], to); };

    std::vector<uint32_t> root(vertices);
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        const uint32_t a = corner(i), b = corner(next(i));
        if (count(b, a) != 1) return "an edge has not one opposite";  // asked from both sides, so each is there once
        root[find(a)] = find(b);
    }
    std::vector<long> euler(vertices, 0);  // twice V - E + F, at each component's root
    for (uint32_t v = 0; v < vertices; ++v) {
        if (first[v] == first[v + 1]) return "a vertex is not used";
        euler[find(v)] += 2;
    }
    for (const uint32_t v : mesh.indices) --euler[find(v)];  // each corner begins half an edge
    for (size_t i = 0; i < mesh.indices.size(); i += 3) euler[find(corner(i))] += 2;
    size_t found = 0;
    for (uint32_t v = 0; v < vertices; ++v) {
        if (find(v) != v) continue;
        ++found;
        if (euler[v] != 4) return "a component's Euler characteristic is not 2";
    }
    return found > 0 ? "" : "empty";
}

/// The same for triangles whose height is below a millionth of their longest edge, and normals that are not of unit length.
inline std::string brokenTriangles(const dapple::scenegen::Mesh& mesh) {
    if (mesh.normals.size() != mesh.positions.size()) return "a vertex without normal";
    for (const glm::vec3& n : mesh.normals)
        if (!(std::abs(glm::dot(n, n) - 1) < 2e-5f)) return "a normal is not of unit length";
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]], c = mesh.positions[mesh.indices[i + 2]];
        const glm::dvec3 cross = glm::cross(b - a, c - a);
        const double longest = std::max({glm::dot(b - a, b - a), glm::dot(c - a, c - a), glm::dot(c - b, c - b)});
        if (!(glm::dot(cross, cross) > 1e-12 * longest * longest)) return "a triangle is degenerate";
    }
    return "";
}
