#include "shadow/volume/silhouette.h"

#include "base/error.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

#include <set>

namespace dapple::shadow {
namespace {

scenegen::Prototype closedPrototype(std::vector<scenegen::Mesh> meshes) {
    scenegen::Prototype prototype;
    prototype.meshes = std::move(meshes);
    prototype.closed = true;
    return prototype;
}

bool runs(const Silhouettes::Face& face, uint32_t from, uint32_t to) {
    for (int k = 0; k < 3; ++k)
        if (face.corners[k] == from && face.corners[(k + 1) % 3] == to) return true;
    return false;
}

/// Of prototypes that stand one behind the other in the buffers.
TEST(Silhouettes, EachEdgeLiesBetweenTheTwoFacesThatRunAlongIt) {
    Silhouettes silhouettes;
    const Silhouettes::Range box = silhouettes.add(closedPrototype({scenegen::boxMesh({2, 3, 4})}));
    const Silhouettes::Range two = silhouettes.add(closedPrototype({scenegen::sphereMesh(1, 2), scenegen::boxMesh({1, 1, 1})}));
    EXPECT_EQ(box.faces, 12u);
    EXPECT_EQ(two.firstFace, 12u);
    EXPECT_EQ(two.faces, 320u + 12u);
    EXPECT_EQ(two.firstEdge(), 18u);
    ASSERT_EQ(silhouettes.edges.size(), two.firstEdge() + two.edges());
    std::set<std::pair<uint32_t, uint32_t>> seen;
    for (size_t i = 0; i < silhouettes.edges.size(); ++i) {
        const auto& [from, to, left, right] = silhouettes.edges[i];
        EXPECT_TRUE(runs(silhouettes.faces[left], from, to)) << i;
        EXPECT_TRUE(runs(silhouettes.faces[right], to, from)) << i;
        EXPECT_EQ(left < two.firstFace, i < two.firstEdge()) << i;
        EXPECT_TRUE(seen.emplace(std::minmax(from, to)).second) << i;
    }
}

TEST(Silhouettes, NormalsAreUnitAndOutward) {
    Silhouettes silhouettes;
    silhouettes.add(closedPrototype({scenegen::sphereMesh(3, 2)}));
    for (const Silhouettes::Face& face : silhouettes.faces) {
        const glm::vec3 normal(face.normal);
        EXPECT_NEAR(glm::length(normal), 1, 1e-6);
        // A facet of a sphere about the origin looks along its own centre.
        const glm::vec4 centre = silhouettes.corners[face.corners.x] + silhouettes.corners[face.corners.y] + silhouettes.corners[face.corners.z];
        EXPECT_GT(glm::dot(normal, glm::normalize(glm::vec3(centre))), 0.99f);
    }
}

TEST(Silhouettes, OpenPrototypesAreRefusedByName) {
    scenegen::Prototype open = closedPrototype({scenegen::boxMesh({1, 1, 1})});
    open.meshes[0].indices.resize(30);
    open.closed = false;
    open.name = "lidless";
    Silhouettes silhouettes;
    try {
        silhouettes.add(open);
        FAIL();
    } catch (const base::UsageError& e) {
        EXPECT_NE(std::string(e.what()).find("lidless"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace dapple::shadow
