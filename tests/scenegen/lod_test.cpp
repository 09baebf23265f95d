#include "scenegen/lod/connectivity.h"
#include "scenegen/lod/decimate.h"
#include "scenegen/plants/tree.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

using namespace dapple::scenegen;

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
