#include "gpuscene/pack.h"

#include "base/random.h"
#include "scenegen/library.h"
#include "scenegen/lod/grid.h"
#include "scenegen/plants/species.h"
#include "scenegen/plants/tree.h"

#include <glm/gtc/packing.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace dapple::gpuscene {
namespace {

using scenegen::Mesh;

glm::vec3 unpackOctahedral(glm::vec2 o) {  // as lib/instance.glsl
    glm::vec3 n(o, 1 - std::abs(o.x) - std::abs(o.y));
    const float below = std::max(-n.z, 0.0f);
    n.x += n.x >= 0 ? -below : below;
    n.y += n.y >= 0 ? -below : below;
    return glm::normalize(n);
}

double degrees(const glm::vec3& a, const glm::vec3& b) { return glm::degrees(2 * std::asin(0.5 * double(glm::length(a - b)))); }

/// `count` leaves of random places within `extent` metres.
Mesh leaves(size_t count, float extent, uint64_t seed) {
    base::Random random(seed, 0, 0);
    Mesh mesh;
    for (uint32_t i = 0; i < 4 * count; ++i) {
        mesh.positions.push_back({random.next(-extent, extent), random.next(0, extent), random.next(-extent, 0)});
        mesh.normals.push_back(glm::normalize(glm::vec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1))));
    }
    for (uint32_t i = 0; i < count; ++i)
        for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(4 * i + corner);
    return mesh;
}

TEST(Packing, aCompactPositionIsTheFloatToTheBit) {
    for (const float extent : {1e-3f, 0.7f, 13.0f, 100.0f})
        for (uint64_t seed = 0; seed < 5; ++seed) {
            Mesh mesh = leaves(500, extent, seed);
            scenegen::snapToGrid(mesh);
            const Packing packing = choosePacking(mesh);
            ASSERT_EQ(packing.vertices, Packing::Vertices::compact) << extent;
            for (size_t v = 0; v < mesh.positions.size(); ++v) {
                const CompactVertex stored(packing, mesh.positions[v], mesh.normals[v]);
                for (int k = 0; k < 3; ++k) ASSERT_EQ(packing.grid[k] + packing.grid.w * float(stored.position[k]), mesh.positions[v][k]);
                const glm::vec3 n = unpackOctahedral({float(stored.normal[0]) / 127, float(stored.normal[1]) / 127});
                ASSERT_LT(degrees(n, mesh.normals[v]), 1.0);
                const FloatVertex plain(mesh.positions[v], mesh.normals[v]);
                ASSERT_EQ(plain.position, mesh.positions[v]);
                ASSERT_LT(degrees(unpackOctahedral({float(plain.normal[0]) / 32767, float(plain.normal[1]) / 32767}), mesh.normals[v]), 0.1);
            }
        }
}

TEST(Packing, whatIsOnNoGridStaysFloat) {
    EXPECT_EQ(choosePacking(leaves(500, 13, 1)).vertices, Packing::Vertices::floats) << "random floats";
    Mesh far = leaves(2, 1, 1);
    scenegen::snapToGrid(far);
    EXPECT_NE(choosePacking(far).vertices, Packing::Vertices::floats);
    far.positions.push_back({1000, 0, 0});
    EXPECT_EQ(choosePacking(far).vertices, Packing::Vertices::floats);
    Mesh textured = leaves(2, 1, 1);
    scenegen::snapToGrid(textured);
    textured.uvs.assign(8, {0.5f, 1});
    EXPECT_NE(choosePacking(textured).vertices, Packing::Vertices::floats);
    textured.uvs[3].x = 0.1f;  // no half is a tenth
    EXPECT_EQ(choosePacking(textured).vertices, Packing::Vertices::floats);
}

TEST(Packing, indicesAreAsShortAsTheyCanBe) {
    using enum Packing::Indices;
    Mesh mesh = leaves(kSharedQuads, 1, 1);
    EXPECT_EQ(choosePacking(mesh).indices, quads);
    std::swap(mesh.indices[0], mesh.indices[1]);
    EXPECT_EQ(choosePacking(mesh).indices, bits16);
    mesh = leaves(kSharedQuads + 1, 1, 1);
    EXPECT_EQ(choosePacking(mesh).indices, bits32);
}

TEST(Packing, aFlatMeshStoresNoNormals) {
    Mesh box;  // two sides of a box, each of two triangles
    box.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 2}, {1, 0, 2}, {1, 0, 0}};
    for (int v = 0; v < 8; ++v) box.normals.push_back(v < 4 ? glm::vec3(0, 0, -1) : glm::vec3(0, -1, 0));
    box.indices = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    EXPECT_EQ(choosePacking(box).vertices, Packing::Vertices::flat);
    EXPECT_EQ(choosePacking(box).bytes(box), 8u * 6);
    for (int v = 0; v < 8; ++v) {
        const FlatVertex stored(choosePacking(box), box.positions[size_t(v)]);
        for (int k = 0; k < 3; ++k) EXPECT_EQ(choosePacking(box).grid[k] + choosePacking(box).grid.w * float(stored.position[k]), box.positions[size_t(v)][k]);
    }
    box.normals[5] = glm::normalize(glm::vec3(0, -1, 0.03f));  // 1.7 degrees off
    EXPECT_EQ(choosePacking(box).vertices, Packing::Vertices::compact);
}

// Over the registry: every scene that dapple makes.
TEST(Packing, scenesTakeAtMostSixteenBytesATriangle) {
    for (const scenegen::SceneEntry& entry : scenegen::listScenes()) {
        const scenegen::Scene scene = scenegen::loadScene(entry.name, {"scale=0.1"});
        const size_t triangles = scene.facts().uniqueTriangles;
        // A box or two are a few kilobytes; triangles without area share no vertex and lie on no grid.
        if (triangles < 1000 || entry.name == "extreme-slivers") continue;
        EXPECT_LE(double(packedBytes(scene)) / double(triangles), 16.0) << entry.name;
    }
}

TEST(Packing, bytesByHand) {
    Mesh mesh = leaves(10, 1, 1);  // 40 vertices, 20 triangles
    EXPECT_EQ(choosePacking(mesh).bytes(mesh), 40u * 16);
    scenegen::snapToGrid(mesh);
    EXPECT_EQ(choosePacking(mesh).bytes(mesh), 40u * 8);
    mesh.uvs.assign(40, {1, 0});
    EXPECT_EQ(choosePacking(mesh).bytes(mesh), 40u * (8 + 4));
    std::swap(mesh.indices[0], mesh.indices[1]);
    EXPECT_EQ(choosePacking(mesh).bytes(mesh), 40u * (8 + 4) + 60 * 2);
}

// Over the registry: plants take at most 16 bytes a triangle, and the grid takes nothing from their shape.
TEST(Packing, everySpeciesIsCompactAtEveryLevelOfDetail) {
    for (const std::string& name : scenegen::listSpecies()) {
        SCOPED_TRACE(name);
        const scenegen::Species species = scenegen::loadSpecies(name);
        for (int lod = 0; lod < scenegen::kLods; ++lod) {
            const scenegen::Tree tree = growTree(species, {7, species.triangles[size_t(lod)], scenegen::LeafMode::polygon, lod});
            size_t bytes = 0, triangles = 0;
            for (Mesh mesh : {tree.bark, tree.leaves}) {
                const Mesh before = mesh;
                scenegen::snapToGrid(mesh);
                EXPECT_NE(choosePacking(mesh).vertices, Packing::Vertices::floats) << "lod " << lod;
                // Half a step along each axis, and the step is below 1 mm for whatever is below 64 m.
                const float step = choosePacking(mesh).grid.w;
                EXPECT_LE(step, 1.0f / 1024);
                for (size_t v = 0; v < mesh.positions.size(); ++v) ASSERT_LE(glm::distance(mesh.positions[v], before.positions[v]), 0.8661f * step);
                bytes += choosePacking(mesh).bytes(mesh);
                triangles += mesh.triangles();
            }
            EXPECT_LE(double(bytes) / double(triangles), 16.0) << "lod " << lod;
        }
    }
}

TEST(Grid, aMeshThatWouldSufferStaysAsItIs) {
    Mesh mesh = leaves(3, 900, 1);  // a step would be 3 cm
    const Mesh before = mesh;
    scenegen::snapToGrid(mesh);
    EXPECT_EQ(mesh.positions, before.positions);
    // A needle's tip of 20 µm in a mesh of 60 m: its triangle would collapse.
    mesh = Mesh{{{0, 0, 0}, {60, 0, 0}, {0, 60, 0}, {30, 30, 5}, {30.00002f, 30, 5}, {30, 30.00002f, 5}}, std::vector<glm::vec3>(6, {0, 0, 1}), {}, {0, 1, 2, 3, 4, 5}, 0};
    const Mesh needle = mesh;
    scenegen::snapToGrid(mesh);
    EXPECT_EQ(mesh.positions, needle.positions);
}

}  // namespace
}  // namespace dapple::gpuscene
