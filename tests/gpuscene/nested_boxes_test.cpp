#include "gpuscene/nested_boxes.h"

#include "base/random.h"
#include "scenegen/primitives.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dapple::gpuscene {
namespace {

bool holds(const NestedBox& box, const glm::vec3& p) { return glm::all(glm::greaterThanEqual(p, box.lo)) && glm::all(glm::lessThanEqual(p, box.hi)); }

/// That boxes lie in one another, and each triangle in an innermost one, of which there are so many.
size_t check(const std::vector<NestedBox>& boxes, const scenegen::Prototype& prototype) {
    size_t innermost = 0;
    EXPECT_EQ(boxes.front().next, boxes.size());
    for (uint32_t n = 0; n < boxes.size(); ++n) {
        EXPECT_GT(boxes[n].next, n);
        for (uint32_t inner = n + 1; inner < boxes[n].next; inner = boxes[inner].next) {
            EXPECT_LE(boxes[inner].next, boxes[n].next);
            EXPECT_TRUE(holds(boxes[n], boxes[inner].lo) && holds(boxes[n], boxes[inner].hi));
        }
        innermost += boxes[n].next == n + 1;
    }
    for (const scenegen::Mesh& mesh : prototype.meshes)
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            bool held = false;
            for (uint32_t n = 0; n < boxes.size() && !held; ++n) {
                held = boxes[n].next == n + 1;
                for (size_t c = i; c < i + 3; ++c) held = held && holds(boxes[n], mesh.positions[mesh.indices[c]]);
            }
            EXPECT_TRUE(held) << "triangle " << i / 3;
        }
    return innermost;
}

TEST(NestedBoxes, HoldEveryTriangleEverMoreTightly) {
    scenegen::Scene scene;
    base::Random random(5, 0, 0);
    for (const size_t count : {1, 2, 3, 40, 700, 9000}) {
        scenegen::Prototype& prototype = scene.prototypes.emplace_back();
        for (size_t i = 0; i < count; ++i) {
            scenegen::Mesh& mesh = i % 100 == 0 ? prototype.meshes.emplace_back() : prototype.meshes.back();
            const glm::vec3 at(random.next(-50, 50), random.next(-50, 50), random.next(0, 20));
            for (const glm::vec3& corner : {glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(1, 0, 1)}) {
                mesh.indices.push_back(uint32_t(mesh.positions.size()));
                mesh.positions.push_back(at + corner);
            }
        }
        Part part{uint32_t(scene.prototypes.size() - 1), prototype.box(), true, count, {}};
        const size_t innermost = check(nestedBoxes(scene, part), prototype);
        EXPECT_GE(innermost, std::min(count, size_t(3000)) / 2);
        EXPECT_LE(innermost, std::min(count, size_t(5000)));
        --part.triangles;
        EXPECT_EQ(nestedBoxes(scene, part).size(), 1u) << "a cluster is a box";
    }
}

// Four walls and no roof: nine tenths of the box about them is air.
TEST(NestedBoxes, LeaveOutACourt) {
    scenegen::Scene scene;
    scenegen::Prototype& court = scene.prototypes.emplace_back();
    for (const int side : {-1, 1})
        for (const bool along : {false, true}) {
            scenegen::Mesh wall = scenegen::boxMesh(along ? glm::vec3(40, 1, 10) : glm::vec3(1, 40, 10));
            for (glm::vec3& p : wall.positions) p += along ? glm::vec3(0, 20 * side, 0) : glm::vec3(20 * side, 0, 0);
            court.meshes.push_back(wall);
        }
    const std::vector<NestedBox> boxes = nestedBoxes(scene, {0, court.box(), true, court.triangles(), {}});
    EXPECT_EQ(boxes.size(), 2 * check(boxes, court) - 1);
    for (uint32_t n = 0; n < boxes.size(); ++n)
        if (boxes[n].next == n + 1) { EXPECT_FALSE(holds(boxes[n], {0, 0, 5})); }
}

TEST(NestedBoxes, OfNoTriangleAreTheBoxOfThePart) {
    scenegen::Scene scene;
    scene.prototypes.emplace_back();
    const std::vector<NestedBox> boxes = nestedBoxes(scene, {0, base::Box{{1, 2, 3}, {4, 5, 6}}, true, 0, {}});
    ASSERT_EQ(boxes.size(), 1u);
    EXPECT_EQ(boxes[0].next, 1u);
    EXPECT_EQ(boxes[0].hi, glm::vec3(4, 5, 6));
}

}  // namespace
}  // namespace dapple::gpuscene
