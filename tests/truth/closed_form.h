#pragma once

#include "truth/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

/// Hand-built scenes and the closed forms of their shadows, in double and independent of Embree.
namespace dapple::truth::test {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

inline scenegen::Mesh meshOf(const std::vector<dvec3>& positions, const std::vector<uint32_t>& indices) {
    scenegen::Mesh mesh;
    for (const dvec3& p : positions) mesh.positions.emplace_back(p);
    mesh.normals.assign(mesh.positions.size(), vec3(0, 0, 1));  // shading only: nothing here reads them
    mesh.indices = indices;
    return mesh;
}

inline scenegen::Mesh boxMesh(const dvec3& lo, const dvec3& hi) {
    std::vector<dvec3> p;
    for (int i = 0; i < 8; ++i) p.push_back({i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z});
    return meshOf(p, {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5});
}

/// Latitude-longitude sphere, inscribed.
inline scenegen::Mesh sphereMesh(const dvec3& centre, double radius, int rings, int sectors) {
    std::vector<dvec3> p;
    std::vector<uint32_t> indices;
    for (int r = 0; r <= rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const double t = M_PI * r / rings, f = 2 * M_PI * s / sectors;
            p.push_back(centre + radius * dvec3(std::sin(t) * std::cos(f), std::sin(t) * std::sin(f), std::cos(t)));
        }
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const auto at = [&](int i, int j) { return uint32_t(i * sectors + j % sectors); };
            const uint32_t a = at(r, s), b = at(r, s + 1), c = at(r + 1, s), d = at(r + 1, s + 1);
            if (r > 0) indices.insert(indices.end(), {a, c, b});
            if (r + 1 < rings) indices.insert(indices.end(), {b, c, d});
        }
    return meshOf(p, indices);
}

/// Largest ball about `centre` inside the convex mesh: the smallest distance to the plane of a triangle.
inline double inscribedRadius(const scenegen::Mesh& mesh, const dvec3& centre) {
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const dvec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]], c = mesh.positions[mesh.indices[i + 2]];
        least = std::min(least, std::abs(glm::dot(glm::normalize(glm::cross(b - a, c - a)), centre - a)));
    }
    return least;
}

inline scenegen::Scene sceneOf(std::vector<scenegen::Mesh> meshes) {
    scenegen::Scene scene;
    scene.name = "closed form";
    scene.materials.resize(1);
    scene.views.resize(1);
    scene.prototypes.push_back({"caster", std::move(meshes), true, false});
    scene.instances.push_back({vec3(0), 1, 0, 0});
    return scene;
}

/// Does the ray from p towards `d` meet the box? (ray-slab test)
inline bool hitsBox(const dvec3& p, const dvec3& d, const dvec3& lo, const dvec3& hi) {
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        if (d[k] == 0) {
            if (p[k] < lo[k] || p[k] > hi[k]) return false;
            continue;
        }
        const double a = (lo[k] - p[k]) / d[k], b = (hi[k] - p[k]) / d[k];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

inline bool hitsBall(const dvec3& p, const dvec3& d, const dvec3& centre, double radius) {
    const dvec3 m = centre - p;
    const double along = glm::dot(m, d), gap2 = glm::dot(m, m) - along * along;
    return gap2 <= radius * radius && along + std::sqrt(radius * radius - gap2) >= 0;
}

/// What a closed form says of one point, given that the tracer's start may be off by a small known band.
enum class Expected { lit, shadowed, either };

struct Point {
    dvec3 position, normal{0, 0, 1};
};

struct Patch {
    std::vector<Point> points;
    Receivers receivers;
};

/// Receivers of the given points as a G-buffer would hold them, `noise` · distance off along the view ray.
inline Patch patchOf(std::vector<Point> points, int width, const dvec3& eye, double noise = 0) {
    Patch patch{std::move(points), {}};
    Receivers& r = patch.receivers;
    r.width = width;
    r.height = int(patch.points.size()) / width;
    std::mt19937 random(7);
    for (const Point& p : patch.points) {
        const double off = 2.0 * double(random()) / double(std::mt19937::max()) - 1.0;
        r.position.emplace_back((p.position - eye) * (1 + noise * off));
        r.normal.emplace_back(p.normal);
        r.present.push_back(1);
    }
    return patch;
}

/// n × n points of the plane z = 0 over [−half, half]², rows from the top.
inline std::vector<Point> planeGrid(int n, double half, const dvec3& centre = dvec3(0)) {
    std::vector<Point> points;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            points.push_back({centre + dvec3(((x + 0.5) / n * 2 - 1) * half, (1 - (y + 0.5) / n * 2) * half, 0)});
    return points;
}

}  // namespace dapple::truth::test
