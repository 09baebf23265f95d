#include "base/random.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/lod/decimate.h"
#include "scenegen/plants/tree.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

using namespace dapple::scenegen;
using dapple::base::Random;

namespace {

double area(const Mesh& m) {
    double sum = 0;
    for (size_t i = 0; i < m.indices.size(); i += 3) {
        const glm::dvec3 a = m.positions[m.indices[i]], b = m.positions[m.indices[i + 1]], c = m.positions[m.indices[i + 2]];
        sum += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return sum;
}

}  // namespace

TEST(Connectivity, boxAndSphereAreSpheres) {
    for (const Mesh& mesh : {boxMesh({1, 2, 3}), sphereMesh(1, 3)}) {
        const Connectivity c = connectivity(mesh);
        EXPECT_TRUE(c.closed());
        EXPECT_TRUE(c.spheres);
        EXPECT_EQ(c.components, 1u);
    }
}

TEST(Connectivity, sphereMeshIsASphere) {
    const Mesh sphere = sphereMesh(2, 5);
    EXPECT_EQ(sphere.triangles(), 20u * 1024);
    EXPECT_NEAR(area(sphere), 4 * M_PI * 4, 0.02 * 4 * M_PI);
    for (size_t i = 0; i < sphere.positions.size(); ++i) EXPECT_LT(glm::distance(sphere.positions[i], 2.0f * sphere.normals[i]), 1e-6f);
}

TEST(Connectivity, aHoleIsOpen) {
    Mesh mesh = boxMesh({1, 1, 1});
    mesh.indices.resize(mesh.indices.size() - 3);
    const Connectivity c = connectivity(mesh);
    EXPECT_FALSE(c.closed());
    EXPECT_EQ(c.boundary, 3u);
    EXPECT_FALSE(c.spheres);
}

TEST(Connectivity, aTurnedTriangleIsNotOriented) {
    Mesh mesh = boxMesh({1, 1, 1});
    std::swap(mesh.indices[0], mesh.indices[1]);
    EXPECT_FALSE(connectivity(mesh).oriented);
}

TEST(Connectivity, aThirdFaceOnAnEdgeIsNotManifold) {
    Mesh mesh = boxMesh({1, 1, 1});
    const uint32_t apex = uint32_t(mesh.positions.size());
    mesh.positions.push_back({3, 3, 3});
    mesh.normals.push_back({0, 0, 1});
    mesh.indices.insert(mesh.indices.end(), {mesh.indices[0], mesh.indices[1], apex});
    EXPECT_EQ(connectivity(mesh).nonManifold, 1u);
    EXPECT_FALSE(connectivity(mesh).closed());
}

TEST(Connectivity, aTorusIsClosedButNoSphere) {
    Mesh mesh;
    constexpr uint32_t n = 12;
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
            const double u = 2 * M_PI * i / n, v = 2 * M_PI * j / n;
            mesh.positions.emplace_back((2 + std::cos(v)) * std::cos(u), (2 + std::cos(v)) * std::sin(u), std::sin(v));
            mesh.normals.emplace_back(0, 0, 1);
            const uint32_t a = i * n + j, b = (i + 1) % n * n + j, c = (i + 1) % n * n + (j + 1) % n, d = i * n + (j + 1) % n;
            mesh.indices.insert(mesh.indices.end(), {a, b, c, a, c, d});
        }
    EXPECT_TRUE(connectivity(mesh).closed());
    EXPECT_FALSE(connectivity(mesh).spheres);
}

TEST(Connectivity, aDegenerateTriangleIsSeen) {
    Mesh mesh = boxMesh({1, 1, 1});
    mesh.positions.push_back(0.5f * (mesh.positions[0] + mesh.positions[1]));
    mesh.normals.push_back({0, 0, 1});
    mesh.indices.insert(mesh.indices.end(), {0, 1, uint32_t(mesh.positions.size() - 1)});
    EXPECT_EQ(connectivity(mesh).degenerate, 1u);
}

TEST(IsClosed, needsEveryEdgeOnceInEachDirection) {
    Mesh m;
    m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};  // the last repeats the first: a seam
    m.indices = {4, 2, 1, 0, 1, 3, 4, 3, 2, 1, 2, 3};
    EXPECT_TRUE(isClosed(m));
    Mesh flipped = m;
    std::swap(flipped.indices[1], flipped.indices[2]);
    EXPECT_FALSE(isClosed(flipped));
    Mesh open = m;
    open.indices.resize(9);
    EXPECT_FALSE(isClosed(open));
    Mesh doubled = m;
    doubled.indices.insert(doubled.indices.end(), m.indices.begin(), m.indices.end());
    EXPECT_FALSE(isClosed(doubled));
    EXPECT_FALSE(isClosed(Mesh{}));
}

/// Counts of every directed edge between positions, all pairs compared.
bool closedByCounting(const Mesh& m) {
    const auto at = [&](size_t i) { return m.positions[m.indices[i]]; };
    for (size_t i = 0; i < m.indices.size(); ++i) {
        const glm::vec3 a = at(i), b = at(i % 3 == 2 ? i - 2 : i + 1);
        int same = 0, opposite = 0;
        for (size_t k = 0; k < m.indices.size(); ++k) {
            const glm::vec3 c = at(k), d = at(k % 3 == 2 ? k - 2 : k + 1);
            same += a == c && b == d;
            opposite += a == d && b == c;
        }
        if (same != 1 || opposite != 1) return false;
    }
    return !m.indices.empty();
}

TEST(IsClosed, agreesWithCountingOnDamagedMeshes) {
    int closed = 0;
    for (uint64_t seed = 0; seed < 300; ++seed) {
        Random random(seed, 0, 1);
        // Two boxes, apart or sharing a corner, an edge or a face.
        Mesh m = boxMesh({1, 1, 1});
        const glm::vec3 shift{float(int(3 * random.next())) * 0.5f + 0.5f, float(int(3 * random.next())) * 0.5f, seed % 3 ? 2.0f : 1.0f};
        for (size_t i = 0, n = m.positions.size(); i < n; ++i) m.positions.push_back(m.positions[i] + shift);
        for (size_t i = 0, n = m.indices.size(); i < n; ++i) m.indices.push_back(m.indices[i] + uint32_t(m.positions.size() / 2));
        const auto pick = [&] { return size_t(random.next() * float(m.indices.size())) / 3 * 3; };
        const float damage = random.next();
        if (damage < 0.2f) m.indices.erase(m.indices.begin() + std::ptrdiff_t(pick()), m.indices.end());
        else if (damage < 0.4f) std::swap(m.indices[pick()], m.indices[pick()]);
        else if (damage < 0.5f) std::swap(m.indices[0], m.indices[1]);
        else if (damage < 0.6f) m.indices.insert(m.indices.end(), m.indices.begin(), m.indices.begin() + 3);
        else if (damage < 0.7f) m.positions[m.indices[pick()]].x += 1e-6f;
        EXPECT_EQ(isClosed(m), closedByCounting(m)) << "seed " << seed;
        closed += isClosed(m);
    }
    EXPECT_GT(closed, 50);
    EXPECT_LT(closed, 200);
}

TEST(IsClosed, bothZerosAreOnePlace) {
    Mesh m = boxMesh({1, 1, 1});
    for (glm::vec3& p : m.positions) p += 0.5f;
    bool minus = false;
    for (glm::vec3& p : m.positions)
        if (p.x == 0 && (minus = !minus)) p.x = -0.0f;
    EXPECT_TRUE(isClosed(m));
    EXPECT_TRUE(connectivity(m).closed());
}

TEST(Decimate, woodStaysClosedAndFoliageKeepsItsArea) {
    Tree tree = growTree(loadSpecies("oak"), {2, 20000, LeafMode::polygon});
    const Prototype fine{"oak", {tree.bark, tree.leaves}, true, false};
    for (const double keep : {0.5, 0.2}) {
        const Prototype coarse = decimate(fine, keep);
        ASSERT_EQ(coarse.meshes.size(), 2u);
        const Connectivity bark = connectivity(coarse.meshes[0]);
        EXPECT_TRUE(bark.closed());
        EXPECT_TRUE(bark.spheres);
        // A tube cannot become less than a tetrahedron, so few triangles per branch bound the thinning from below.
        const double floor = 4.0 * double(bark.components) / double(fine.meshes[0].triangles());
        EXPECT_NEAR(double(coarse.meshes[0].triangles()), std::max(keep, floor) * double(fine.meshes[0].triangles()), 0.1 * double(fine.meshes[0].triangles()));
        EXPECT_NEAR(double(coarse.meshes[1].triangles()), keep * double(fine.meshes[1].triangles()), 3);
        EXPECT_NEAR(area(coarse.meshes[1]) / area(fine.meshes[1]), 1, 0.05);
        for (const glm::vec3& n : coarse.meshes[0].normals) ASSERT_NEAR(glm::length(n), 1, 1e-5);
        const auto a = fine.box(), b = coarse.box();
        EXPECT_LT(glm::distance(a.lo, b.lo), 1.0f);
        EXPECT_LT(glm::distance(a.hi, b.hi), 1.0f);
    }
}

TEST(Decimate, aWholeShareChangesNothing) {
    const Prototype sphere{"sphere", {sphereMesh(1, 2)}, true, true};
    EXPECT_EQ(decimate(sphere, 1).meshes[0].positions, sphere.meshes[0].positions);
}
