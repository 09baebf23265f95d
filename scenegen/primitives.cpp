#include "scenegen/primitives.h"

#include "base/detmath.h"
#include "base/random.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/require_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace dapple::scenegen {

constexpr size_t kBytesPerCopy = 100;    // an instance, here and in every list over instances
constexpr size_t kBytesPerSliver = 170;  // three vertices and indices, and the copy that the GPU is handed

Mesh boxMesh(const glm::vec3& size) {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0f, 1.0f}) {
            glm::vec3 n(0), u(0), v(0);
            n[axis] = sign, u[(axis + 1) % 3] = sign, v[(axis + 2) % 3] = 1;
            const auto base = uint32_t(mesh.positions.size());
            for (const glm::vec3& corner : {n - u - v, n + u - v, n + u + v, n - u + v}) {
                mesh.positions.push_back(0.5f * size * corner);
                mesh.normals.push_back(n);
            }
            for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + i);
        }
    return mesh;
}

Mesh sphereMesh(float radius, int refine) {
    const double a = 1, b = (1 + std::sqrt(5.0)) / 2;
    std::vector<glm::dvec3> points{{-a, b, 0}, {a, b, 0}, {-a, -b, 0}, {a, -b, 0}, {0, -a, b}, {0, a, b},
                                   {0, -a, -b}, {0, a, -b}, {b, 0, -a}, {b, 0, a}, {-b, 0, -a}, {-b, 0, a}};
    for (glm::dvec3& p : points) p = glm::normalize(p);
    std::vector<uint32_t> triangles{0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10, 7, 6, 7, 1, 8,
                                    3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10, 8, 6, 7, 9, 8, 1};
    for (int level = 0; level < refine; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t i, uint32_t j) {
            const auto [at, isNew] = middles.try_emplace(std::minmax(i, j), uint32_t(points.size()));
            if (isNew) points.push_back(glm::normalize(points[i] + points[j]));
            return at->second;
        };
        std::vector<uint32_t> finer;
        for (size_t t = 0; t < triangles.size(); t += 3) {
            const uint32_t i = triangles[t], j = triangles[t + 1], k = triangles[t + 2];
            const uint32_t ij = middle(i, j), jk = middle(j, k), ki = middle(k, i);
            finer.insert(finer.end(), {i, ij, ki, ij, j, jk, ki, jk, k, ij, jk, ki});
        }
        triangles = std::move(finer);
    }
    Mesh mesh;
    mesh.indices = std::move(triangles);
    for (const glm::dvec3& p : points) {
        mesh.positions.emplace_back(p * double(radius));
        mesh.normals.emplace_back(p);
    }
    return mesh;
}

Mesh sliverMesh(const glm::vec3& size, size_t count, uint64_t seed) {
    Mesh mesh;
    base::Random random(seed, 0, 0x736c69766572);
    for (size_t i = 0; i < count; ++i) {
        const glm::vec3 a = size * glm::vec3{random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f};
        const glm::vec3 b = size * glm::vec3{random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f};
        const glm::vec3 third = i % 3 == 0 ? a : i % 3 == 1 ? b : 0.5f * (a + b), second = i % 3 == 0 ? a : b;
        for (const glm::vec3& p : {a, second, third}) {
            mesh.indices.push_back(uint32_t(mesh.positions.size()));
            mesh.positions.push_back(p);
            mesh.normals.emplace_back(0, 0, 1);
        }
    }
    return mesh;
}

glm::vec3 readAlbedo(base::ConfigTable& table, const glm::vec3& fallback) {
    if (!table.has("albedo")) return fallback;
    const std::vector<double> a = table.numbers("albedo", 3);
    for (const double v : a)
        if (v < 0 || v > 1) table.fail("albedo", "an albedo lies between 0 and 1");
    return {a[0], a[1], a[2]};
}

float readTransmittance(base::ConfigTable& table) {
    const double transmittance = table.number("transmittance", 0, 0, 1);
    if (transmittance >= 1) table.fail("transmittance", "lies in 0 ≤ t < 1");
    return float(transmittance);
}

void addPrimitive(Scene& scene, base::ConfigTable& t, uint64_t seed) {
    const auto vec3 = [&](const char* key) {
        const std::vector<double> v = t.numbers(key, 3);
        return glm::dvec3(v[0], v[1], v[2]);
    };
    const std::string kind = t.text("kind");
    const glm::vec3 position(vec3("position"));
    Mesh mesh;
    if (kind == "box" || kind == "slab" || kind == "slivers") {
        const glm::dvec3 size = vec3("size");
        if (!(size.x > 0 && size.y > 0 && size.z > 0)) t.fail("size", "must be above 0");
        const auto slivers = kind == "slivers" ? size_t(t.integer("triangles", 1000, 1, 10'000'000)) : 0;
        requireMemory(t, "triangles", fmt::format("{} slivers", slivers), double(slivers), kBytesPerSliver);
        mesh = kind == "slivers" ? sliverMesh(glm::vec3(size), slivers, seed) : boxMesh(glm::vec3(size));
    } else if (kind == "sphere") {
        const double radius = t.number("radius", 1, 1e-6, 1e6);
        mesh = sphereMesh(float(radius), int(t.integer("refine", 5, 0, 7)));
    } else {
        t.fail("kind", fmt::format("'{}' is none of box, sphere, slab, slivers", kind));
    }
    const auto copies = size_t(t.integer("copies", 1, 1, 100'000'000));
    requireMemory(t, "copies", fmt::format("{} copies", copies), double(copies), kBytesPerCopy);
    const double scatter = t.number("scatter", 0, 0, 1e6);
    const bool turned = t.boolean("turned", false);
    const float transmittance = readTransmittance(t);
    mesh.material = uint32_t(scene.materials.size());
    scene.materials.push_back({.name = kind, .albedo = readAlbedo(t, {0.6f, 0.55f, 0.5f}), .doubleSided = kind == "slivers"});
    t.finish();

    Prototype prototype{kind, {std::move(mesh)}, true, false};
    prototype.closed = isClosed(prototype);
    prototype.transmittance = transmittance;
    scene.prototypes.push_back(std::move(prototype));
    for (size_t i = 0; i < copies; ++i) {
        base::Random random(seed, i, 0x636f7079);
        const glm::dvec2 offset = scatter * (2.0 * glm::dvec2{random.next(), random.next()} - 1.0);
        const float yaw = turned ? float(2 * base::det::kPi * random.next()) : 0.0f;
        scene.instances.push_back({.translation = glm::vec3(glm::dvec3(position) + glm::dvec3(offset, 0)), .yaw = yaw, .prototype = uint32_t(scene.prototypes.size() - 1)});
    }
}

}  // namespace dapple::scenegen
