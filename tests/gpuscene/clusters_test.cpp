#include "gpuscene/clusters.h"

#include "base/random.h"
#include "gpuscene/gpu_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

namespace dapple::gpuscene {
namespace {

/// Small triangles, or quads of two, strewn about; as many vertices as corners.
scenegen::Mesh strewn(size_t count, bool quads, uint64_t seed) {
    scenegen::Mesh mesh;
    base::Random random(seed, 0, 0);
    for (size_t i = 0; i < count; ++i) {
        const glm::vec3 at(random.next(-50, 50), random.next(-50, 50), random.next(0, 20));
        const auto first = uint32_t(mesh.positions.size());
        const glm::vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
        for (int c = 0; c < (quads ? 4 : 3); ++c) mesh.positions.push_back(at + corners[c]);
        for (const uint32_t c : {0u, 1u, 2u}) mesh.indices.push_back(first + c);
        if (quads)
            for (const uint32_t c : {0u, 2u, 3u}) mesh.indices.push_back(first + c);
    }
    mesh.normals.assign(mesh.positions.size(), {0, 1, 0});
    return mesh;
}

using Triangle = std::array<uint32_t, 4>;  // mesh, indices

TEST(Clusters, HoldEachTriangleOnceWithinTheirBoxes) {
    scenegen::Prototype prototype;
    prototype.meshes = {strewn(700, false, 1), strewn(900, true, 2), {}, strewn(30'000, false, 3)};
    GpuPrototype gpu{prototype.box(), false, {}, prototype.triangles()};
    std::multiset<Triangle> expected;
    std::vector<const scenegen::Mesh*> meshes;
    for (const scenegen::Mesh& mesh : prototype.meshes) {
        if (mesh.indices.empty()) continue;
        GpuMesh& m = gpu.meshes.emplace_back();
        m.packing = choosePacking(mesh);
        m.indexCount = uint32_t(mesh.indices.size());
        m.material = uint32_t(meshes.size());
        for (size_t i = 0; i < mesh.indices.size(); i += 3) expected.insert({m.material, mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
        meshes.push_back(&mesh);
    }
    ASSERT_EQ(gpu.meshes[1].packing.indices, Packing::Indices::quads);
    ASSERT_EQ(gpu.meshes[2].packing.indices, Packing::Indices::bits32);
    for (const uint32_t most : {1u, 2u, 100u, 5000u}) {
        constexpr size_t kOffset = 4096;
        std::vector<uint8_t> bytes(8, 0xFF);  // somebody else's
        const std::vector<Part> parts = clusters(prototype, gpu, 6, most, kOffset, bytes);
        std::multiset<Triangle> found;
        size_t triangles = 0;
        for (const Part& part : parts) {
            EXPECT_EQ(part.prototype, 6u);
            EXPECT_FALSE(part.castsShadow);
            EXPECT_LE(part.triangles, std::max(most, 2u));  // of a quad
            size_t own = 0;
            for (const GpuMesh& piece : part.meshes) {
                const scenegen::Mesh& mesh = *meshes[piece.material];
                const bool wide = piece.packing.indices == Packing::Indices::bits32;
                ASSERT_EQ(piece.indexOffset % 4, 0u);
                ASSERT_GE(piece.indexOffset, kOffset + 8);
                std::array<uint32_t, 6> unit{};
                for (uint32_t i = 0; i < piece.indexCount; ++i) {
                    uint32_t index = 0;
                    std::memcpy(&index, &bytes.at(piece.indexOffset - kOffset + i * (wide ? 4 : 2)), wide ? 4 : 2);
                    EXPECT_TRUE(glm::all(glm::greaterThanEqual(mesh.positions[index], part.box.lo)) && glm::all(glm::lessThanEqual(mesh.positions[index], part.box.hi)));
                    unit[i % 6] = index;
                    if (i % 3 == 2) found.insert({piece.material, unit[i % 6 - 2], unit[i % 6 - 1], index});
                    if (piece.material == 1 && i % 6 == 5) { EXPECT_EQ(unit[0], unit[3]) << "a quad was torn apart"; }
                }
                own += piece.indexCount / 3;
            }
            EXPECT_EQ(own, part.triangles);
            triangles += own;
        }
        EXPECT_EQ(triangles, prototype.triangles());
        EXPECT_EQ(found, expected);
        EXPECT_GE(parts.size(), prototype.triangles() / std::max(most, 2u));
    }
}

}  // namespace
}  // namespace dapple::gpuscene
