#include "scenegen/files.h"

#include <algorithm>

// Which way round closed surfaces are. Oracle: signed volumes known in advance.
namespace dapple::scenegen {
namespace {

const std::filesystem::path kFixtures = base::homeFolder() / "tests/fixtures";

/// A box as OBJ text with its own vertices; `inwards` winds it the other way round.
std::string box(const glm::dvec3& lo, const glm::dvec3& hi, bool inwards, const std::string& normals = "") {
    std::string text;
    for (int k = 0; k < 8; ++k)
        text += fmt::format("v {} {} {}\n", k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z);
    const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const int axis[6] = {2, 2, 1, 1, 0, 0}, sign[6] = {-1, 1, -1, 1, -1, 1};
    for (int f = 0; f < 6; ++f) {
        if (!normals.empty()) {
            glm::ivec3 n(0);
            n[axis[f]] = sign[f] * (normals == "inwards" ? -1 : 1);
            text += fmt::format("vn {} {} {}\n", n.x, n.y, n.z);
        }
        text += "f";
        for (int k = 0; k < 4; ++k)
            text += fmt::format(" {}{}", faces[f][inwards ? 3 - k : k] - 8, normals.empty() ? "" : "//-1");
        text += '\n';
    }
    return text;
}

/// Whether all normals of the scene agree with its triangles.
bool normalsAgree(const Scene& scene) {
    for (const Prototype& p : scene.prototypes)
        for (const Mesh& m : p.meshes)
            for (size_t i = 0; i < m.indices.size(); i += 3) {
                const glm::vec3 a = m.positions[m.indices[i]];
                const glm::vec3 n = glm::cross(m.positions[m.indices[i + 1]] - a, m.positions[m.indices[i + 2]] - a);
                for (size_t k = 0; k < 3; ++k)
                    if (!(glm::dot(n, m.normals[m.indices[i + k]]) > 0)) return false;
            }
    return true;
}

bool allClosed(const Scene& scene) {
    return std::ranges::all_of(scene.prototypes, [](const Prototype& p) { return p.closed; }) &&
           std::ranges::none_of(scene.materials, [](const Material& m) { return m.doubleSided; });
}

using Orientation = Files;

TEST(OrientationOfFiles, insideOutBoxesAreTheControlTurned) {
    const Scene control = importFile(kFixtures / "inside-out/control.gltf");
    for (const char* name : {"box.gltf", "doublesided.gltf", "one_of_two.gltf"}) {
        SCOPED_TRACE(name);
        const Scene scene = importFile(kFixtures / "inside-out" / name);
        EXPECT_TRUE(hasNote(scene, "turned outwards"));
        // One box of 3 × 3 × 4 m, or two of 2.5 × 2.5 × 4 m.
        EXPECT_NEAR(signedVolume(scene), scene.facts().triangles == control.facts().triangles ? 36 : 50, 1e-4);
        EXPECT_NEAR(signedVolume(control), 36, 1e-4);
        EXPECT_TRUE(normalsAgree(scene));
        EXPECT_EQ(scene.facts().closed, control.facts().closed);
    }
}

TEST_F(Orientation, normalsOfEitherKindPointOutwardsAfterwards) {
    for (const char* normals : {"", "inwards", "outwards"}) {
        const Scene scene = importFile(write("box.obj", box({-1, 0, -2}, {1, 3, 2}, true, normals)));
        EXPECT_NEAR(signedVolume(scene), 24, 1e-9) << normals;
        EXPECT_TRUE(allClosed(scene) && normalsAgree(scene)) << normals;
    }
}

TEST_F(Orientation, onlyThoseThatFaceInwardsAreTurned) {
    std::string obj;
    for (int i = 0; i < 3; ++i) obj += fmt::format("o box{}\n", i) + box({10 * i, 0, 0}, {10 * i + 2, 2, 2}, i != 1);
    const Scene scene = importFile(write("three.obj", obj));
    EXPECT_NEAR(signedVolume(scene), 24, 1e-6);
    EXPECT_TRUE(allClosed(scene));
}

TEST_F(Orientation, boxesThatTouchAtACornerAreTurnedOneByOne) {
    const Scene scene =
        importFile(write("corner.obj", box({0, 0, 0}, {2, 2, 2}, false) + box({2, 2, 2}, {3, 3, 3}, true)));
    EXPECT_NEAR(signedVolume(scene), 9, 1e-9);
    EXPECT_TRUE(allClosed(scene) && normalsAgree(scene));
}

TEST_F(Orientation, aCavityStays) {
    // 512 - 8: the inner box faces into the cavity, as it must.
    const Scene scene =
        importFile(write("cavity.obj", box({0, 0, 0}, {8, 8, 8}, false) + box({3, 3, 3}, {5, 5, 5}, true)));
    EXPECT_NEAR(signedVolume(scene), 504, 1e-6);
    EXPECT_TRUE(allClosed(scene));
    EXPECT_FALSE(hasNote(scene, "turned"));
}

TEST_F(Orientation, aBoxInTheNotchOfAnLIsNoCavity) {
    // Its box lies in the L's box, but the box itself lies outside.
    const std::string l =
        "v 0 0 0\nv 8 0 0\nv 8 0 -2\nv 2 0 -2\nv 2 0 -8\nv 0 0 -8\nv 0 4 0\nv 8 4 0\nv 8 4 -2\nv 2 4 -2\nv 2 4 -8\nv 0 "
        "4 -8\n"
        "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";
    const Scene alone = importFile(write("l.obj", l));
    EXPECT_NEAR(signedVolume(alone), 4 * (16 + 12), 1e-6);
    const Scene scene = importFile(write("notch.obj", l + box({4, 1, -7}, {6, 3, -5}, true)));
    EXPECT_NEAR(signedVolume(scene), 4 * 28 + 8, 1e-6);
    EXPECT_TRUE(allClosed(scene));
}

TEST_F(Orientation, whatMayFaceInwardsOnPurposeIsDrawnFromBothSides) {
    const std::string view = "[[view]]\nname = \"eye\"\neye = [0, 0, 1.7]\ntarget = [3, 3, 1]\n";
    const std::string outside = "[[view]]\nname = \"eye\"\neye = [20, 0, 1.7]\ntarget = [3, 3, 1]\n";
    const std::string dome = "o dome\n" + box({-5, -1, -5}, {5, 9, 5}, true),
                      chair = "o chair\n" + box({1, 0, 1}, {2, 1, 2}, false);
    const auto open = [&](const std::string& obj, const std::string& toml) {
        write("room.toml", toml);
        const Scene scene = importFile(write("room.obj", obj));
        EXPECT_FALSE(hasNote(scene, "turned"));
        return std::ranges::any_of(scene.prototypes,
                                   [](const Prototype& p) { return !p.closed && p.triangles() >= 12; }) &&
               scene.materials[0].doubleSided;
    };
    EXPECT_TRUE(open(dome, view)) << "a room with nothing but a camera in it";
    EXPECT_TRUE(open(dome + chair, outside)) << "a dome over a scene";
    EXPECT_TRUE(open("o house\n" + box({-9, -2, -9}, {9, 12, 9}, false) + dome, outside))
        << "a room in a house that is an object of its own";
    EXPECT_TRUE(open(box({-5, -1, -5}, {5, 9, 5}, true) + box({1, 0, 1}, {2, 1, 2}, false), outside))
        << "both in one mesh";
    write("room.toml", outside);
    EXPECT_TRUE(hasNote(importFile(write("room.obj", dome)), "turned")) << "an empty one seen from outside";
}

TEST_F(Orientation, manySmallMeshesMergedIntoCellsAreTurnedToo) {
    std::string obj;
    for (int i = 0; i < 100; ++i)
        obj += fmt::format("o b{}\n", i) + box({4 * i, 0, 0}, {4 * i + 1 + 0.01 * i, 1, 1}, i % 3 == 0);
    const Scene scene = importFile(write("row.obj", obj));
    EXPECT_LT(scene.prototypes.size(), 10u);
    EXPECT_NEAR(signedVolume(scene), 100 + 0.01 * 99 * 100 / 2, 1e-3);
    EXPECT_TRUE(allClosed(scene) && normalsAgree(scene));
}

}  // namespace
}  // namespace dapple::scenegen
