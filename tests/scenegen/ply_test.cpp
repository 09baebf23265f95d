#include "base/expect_error.h"
#include "base/image.h"
#include "scenegen/files.h"

#include <algorithm>
#include <cstring>

// Oracle: areas and places of faces that are known in advance.
namespace dapple::scenegen {
namespace {

constexpr double kEast = 3512345.5, kNorth = 5812345.25;

class Ply : public Files {
protected:
    static std::string header(const std::string& format, const std::string& type, size_t faces) {
        return fmt::format(
            "ply\nformat {} 1.0\ncomment made by hand\nobj_info none\nelement vertex 8\nproperty {} x\nproperty {} "
            "y\nproperty {} z\n"
            "property uchar red\nelement face {}\nproperty list uchar int vertex_indices\nproperty short "
            "flags\nend_header\n",
            format, type, type, type, faces);
    }

    /// An L of 3 m² and a quad of 0.0625 m² above it, far from the origin.
    Scene ell(const std::string& format, double east, double north) const {
        std::string bytes = header(format, "double", 2);
        const auto put = [&](auto value) {
            if (format == "ascii") {
                bytes += fmt::format("{} ", value);
                return;
            }
            char raw[sizeof value];
            std::memcpy(raw, &value, sizeof value);
            if (format == "binary_big_endian") std::reverse(raw, raw + sizeof value);
            bytes.append(raw, sizeof value);
        };
        for (const glm::dvec3 p : {glm::dvec3(0, 0, 0),
                                   {2, 0, 0},
                                   {2, 1, 0},
                                   {1, 1, 0},
                                   {1, 2, 0},
                                   {0, 2, 0},
                                   {0.25, 0, 1},
                                   {0.25, 0.25, 1}}) {
            put(east + p.x), put(north + p.y), put(p.z);
            put(uint8_t(7));
        }
        for (const std::vector<int32_t>& face : {std::vector<int32_t>{3, 4, 5, 0, 1, 2}, {0, 6, 7}}) {
            put(uint8_t(face.size()));
            for (const int32_t v : face) put(v);
            put(int16_t(-1));
        }
        return importFile(write("l.ply", bytes));
    }

    std::string error(const std::string& text) const {
        return base::errorLine([&] { importFile(write("e.ply", text)); });
    }
};

const std::string kTriangle =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";

TEST_F(Ply, textAndBothBinariesInDoubles) {
    const double near = area(ell("ascii", 0, 0));
    EXPECT_NEAR(near, 3 + 0.25 * std::sqrt(1.0625) / 2, 1e-6);
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const Scene scene = ell(format, kEast, kNorth);
        EXPECT_EQ(scene.facts().triangles, 5u) << format;
        EXPECT_NEAR(area(scene), near, 1e-5) << format;
        const base::DBox box = worldBox(scene);
        EXPECT_NEAR(box.lo.x, kEast, 1e-4) << format;
        EXPECT_NEAR(box.hi.y, kNorth + 2, 1e-4) << format;
        EXPECT_TRUE(scene.notes.empty()) << format;
    }
}

TEST_F(Ply, stripsTurnEverySecondTriangle) {
    const std::string strip =
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement "
        "tristrips 1\n"
        "property list int int vertex_indices\nend_header\n0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n2 1 0\n"
        "9 1 0 3 2 -1 3 2 5 4\n";
    const Scene scene = importFile(write("s.ply", strip));
    EXPECT_EQ(scene.facts().triangles, 4u);
    EXPECT_NEAR(area(scene), 2, 1e-6);
    const std::vector<glm::dvec3> p = worldCorners(scene);
    for (size_t i = 0; i < p.size(); i += 3)
        EXPECT_EQ(glm::cross(p[i + 1] - p[i], p[i + 2] - p[i]).z > 0, glm::cross(p[1] - p[0], p[2] - p[0]).z > 0) << i;
}

TEST_F(Ply, texturesByVertexAndByCorner) {
    base::writePng(folder_ / "leaf.png", {2, 1, 4, {255, 255, 255, 255, 255, 255, 255, 0}});
    const std::string head =
        "ply\nformat ascii 1.0\ncomment TextureFile Leaf.png\nelement vertex 3\nproperty float x\nproperty float "
        "y\nproperty float z\n";
    const std::string byVertex =
        head +
        "property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
        "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    const std::string byCorner =
        head +
        "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n";
    for (const std::string& text : {byVertex, byCorner}) {
        const Scene scene = importFile(write("t.ply", text));
        EXPECT_TRUE(scene.facts().alphaTested);
        const Mesh& mesh = scene.prototypes.at(0).meshes.at(0);
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_EQ(mesh.uvs.at(v), glm::vec2(mesh.positions[v].x, 1 - mesh.positions[v].y));
    }
    EXPECT_TRUE(hasNote(importFile(write("t.ply", kTriangle.substr(0, 21) + "comment TextureFile gone.png\n" +
                                                      byVertex.substr(head.find("element")))),
                        "'gone.png'"));
}

TEST_F(Ply, badOnesAreOneLineAtOnce) {
    const std::string points = "0 0 0\n1 0 0\n0 1 0\n",
                      faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n" + points;
    base::expectHolds(error(kTriangle + faces + "3 0 1 3\n"), "vertex 4 of 3");
    base::expectHolds(error(kTriangle + faces + "3 0 1 -7\n"), "a face names vertex");
    base::expectHolds(error(kTriangle + faces + "3 0 nan 2\n"), "a face names vertex");
    base::expectHolds(error(kTriangle + faces + "3 0 1\n"), "cut short");
    base::expectHolds(error(kTriangle + faces + "3 0 1 two\n"), "'two' is no number");
    base::expectHolds(error(kTriangle + faces + "4000000000 0 1 2\n"), "list is longer than the file");
    base::expectHolds(error(kTriangle + faces + "-1 0 1 2\n"), "list is longer than the file");
    base::expectHolds(
        error(kTriangle + "element face 18446744073709551615\nproperty list uchar int vertex_indices\nend_header\n" +
              points + "3 0 1 2\n"),
        "cut short");
    base::expectHolds(error("ply\nformat ascii 1.0\nelement face 18446744073709551615\nend_header\n"), "no triangle");
    base::expectHolds(error("ply\nformat ascii 1.0\nelement face 99999999999999999999999\nend_header\n"), "no count");
    base::expectHolds(error("ply\nformat morse 1.0\nend_header\n"), "format");
    base::expectHolds(error("ply\nformat ascii 1.0\nproperty float x\nend_header\n"), "property");
    base::expectHolds(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n"), "property");
    base::expectHolds(error("ply\nformat ascii 1.0\n"), "no end");
    base::expectHolds(error("no ply\n"), "no PLY");
    base::expectHolds(error(kTriangle + "end_header\n" + points), "no triangle");
    base::expectHolds(
        error(kTriangle +
              "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\ninf 1 0\n3 0 1 2\n"),
        "vertex 3 is not finite");
}

using Coarse = Files;

// Where Assimp holds floats, their steps are named.
TEST_F(Coarse, floatsFarFromTheOriginAreNoted) {
    const auto off = [&](double at) {
        return importFile(
            write("far.off", fmt::format("OFF\n3 1 0\n{0} 0 0\n{1} 0 0\n{0} 0 -100\n3 0 1 2\n", at, at + 100)));
    };
    EXPECT_FALSE(hasNote(off(10000), "steps of more than a millimetre"));
    EXPECT_TRUE(hasNote(off(500103.37), "steps of more than a millimetre"));
    std::string dae = base::readFile(base::homeFolder() / "tests/fixtures/units/mx.dae");
    const size_t node = dae.find("<instance_geometry");
    const std::string moved = std::string(dae).insert(node, "<translate>5412365.62 0 0</translate>");
    EXPECT_FALSE(hasNote(importFile(write("at.dae", dae)), "steps of more"));
    EXPECT_TRUE(hasNote(importFile(write("far.dae", moved)), "steps of more than a millimetre ('n: 0.32 m')"));
}

}  // namespace
}  // namespace dapple::scenegen
