#include "scenegen/import/file_space.h"

#include "base/expect_error.h"
#include "scenegen/files.h"

// Units and axes of files. Oracle: a box of known size and place, 1 wide, 2 deep and 3 high in the file's units.
namespace dapple::scenegen {
namespace {

const std::filesystem::path kFixtures = base::homeFolder() / "tests/fixtures";

/// "x y z" of the box's corners and "a b c" of its triangles, each put through `corner` or `triangle`.
template <class Corner, class Triangle>
std::pair<std::string, std::string> boxText(const Corner& corner, const Triangle& triangle) {
    std::string points, triangles;
    for (int k = 0; k < 8; ++k) points += corner(k & 4 ? 1 : 0, k & 2 ? 2 : 0, k & 1 ? 3 : 0);
    for (const auto& t : {glm::ivec3(0, 1, 3),
                          {0, 3, 2},
                          {4, 6, 7},
                          {4, 7, 5},
                          {0, 4, 5},
                          {0, 5, 1},
                          {2, 3, 7},
                          {2, 7, 6},
                          {0, 2, 6},
                          {0, 6, 4},
                          {1, 5, 7},
                          {1, 7, 3}})
        triangles += triangle(t.x, t.y, t.z);
    return {points, triangles};
}

void expectSize(const Scene& scene, const glm::dvec3& size, const std::string& what) {
    const glm::dvec3 is = worldBox(scene).size();
    EXPECT_LT(glm::length(is - size), 1e-5 * glm::length(size)) << what << ": " << is.x << " " << is.y << " " << is.z;
    EXPECT_GT(signedVolume(scene), 0) << what;
}

class FileSpaces : public Files {
protected:
    Scene amf(const std::string& root) const {
        const auto [points, triangles] = boxText(
            [](int x, int y, int z) {
                return fmt::format("<vertex><coordinates><x>{}</x><y>{}</y><z>{}</z></coordinates></vertex>", x, y, z);
            },
            [](int a, int b, int c) {
                return fmt::format("<triangle><v1>{}</v1><v2>{}</v2><v3>{}</v3></triangle>", a, b, c);
            });
        return importFile(write("box.amf", "<?xml version=\"1.0\"?>\n" + root + "<object id=\"0\"><mesh><vertices>" +
                                               points + "</vertices><volume>" + triangles +
                                               "</volume></mesh></object></amf>"));
    }
    Scene x3d(const std::string& head) const {
        const auto [points, triangles] =
            boxText([](int x, int y, int z) { return fmt::format("{} {} {} ", x, y, z); },
                    [](int a, int b, int c) { return fmt::format("{} {} {} -1 ", a, b, c); });
        return importFile(write("box.x3d", "<?xml version=\"1.0\"?><X3D version=\"3.3\" profile=\"Interchange\">" +
                                               head + "<Scene><Shape><IndexedFaceSet coordIndex=\"" + triangles +
                                               "\"><Coordinate point=\"" + points +
                                               "\"/></IndexedFaceSet></Shape></Scene></X3D>"));
    }
    Scene openGex(const std::string& metrics) const {
        const auto [points, triangles] =
            boxText([](int x, int y, int z) { return fmt::format("{}{{{}, {}, {}}}", x + y + z ? "," : "", x, y, z); },
                    [](int a, int b, int c) { return fmt::format("{}{{{}, {}, {}}}", b == 1 ? "" : ",", a, b, c); });
        return importFile(
            write("box.ogex", metrics +
                                  "GeometryNode $node1 { Name {string {\"box\"}} ObjectRef {ref {$geometry1}} }\n"
                                  "GeometryObject $geometry1 { Mesh (primitive = \"triangles\") { VertexArray (attrib "
                                  "= \"position\") { float[3] {" +
                                  points + "} } IndexArray { unsigned_int32[3] {" + triangles + "} } } }\n"));
    }
    Scene dxf(const std::string& header) const {
        std::vector<glm::ivec3> corners;
        const std::string faces = boxText(
                                      [&](int x, int y, int z) {
                                          corners.emplace_back(x, y, z);
                                          return std::string();
                                      },
                                      [&](int a, int b, int c) {
                                          std::string face = "0\n3DFACE\n8\n0\n";
                                          for (int k = 0; k < 4; ++k) {
                                              const glm::ivec3 p = corners[size_t(k == 0 ? a : k == 1 ? b : c)];
                                              face +=
                                                  fmt::format("1{0}\n{1}\n2{0}\n{2}\n3{0}\n{3}\n", k, p.x, p.y, p.z);
                                          }
                                          return face;
                                      })
                                      .second;
        return importFile(write("box.dxf", header + "0\nSECTION\n2\nENTITIES\n" + faces + "0\nENDSEC\n0\nEOF\n"));
    }
    Scene ply(const std::string& sidecar) const {
        const auto [points, triangles] =
            boxText([](int x, int y, int z) { return fmt::format("{} {} {}\n", x, y, z); },
                    [](int a, int b, int c) { return fmt::format("3 {} {} {}\n", a, b, c); });
        write("box.toml", sidecar);
        return importFile(
            write("box.ply",
                  "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 12\nproperty list uchar int vertex_indices\nend_header\n" +
                      points + triangles));
    }
};

TEST_F(FileSpaces, fbxSaysItsUnitAndItsAxes) {
    for (const char* name : {"cm_y", "cm_z", "m_y", "m_z"}) {
        const Scene scene = importFile(kFixtures / fmt::format("fbx/{}.fbx", name));
        expectSize(scene, {3, 3, 4}, name);
        EXPECT_NEAR(worldBox(scene).lo.z, 0, 1e-6) << name;
    }
    // Other axes than these: the file's right goes to x, its front to -y, its up to z. Inches; one axis missing.
    const std::string whole = base::readFile(kFixtures / "fbx/cm_y.fbx");
    const auto with = [&](const std::string& name, const std::string& old, const std::string& value, std::string text) {
        const std::string line = fmt::format("P: \"{}\", \"int\", \"Integer\", \"\",", name);
        return text.replace(text.find(line + old), line.size() + old.size(), line + value);
    };
    const Scene down =
        importFile(write("down.fbx", with("UpAxisSign", "1", "-1", with("CoordAxisSign", "1", "-1", whole))));
    expectSize(down, {3, 3, 4}, "upside down");
    EXPECT_NEAR(worldBox(down).hi.z, 0, 1e-6);
    const Scene mirrored = importFile(write("mirrored.fbx", with("CoordAxisSign", "1", "-1", whole)));
    expectSize(mirrored, {3, 3, 4}, "left-handed");
    EXPECT_FALSE(hasNote(mirrored, "wound inwards"));
    std::string inches = whole;
    inches.replace(inches.find("\"Number\", \"\",1"), 14, "\"Number\", \"\",2.54");
    expectSize(importFile(write("inches.fbx", inches)), glm::dvec3(3, 3, 4) * 2.54, "inches");
    expectSize(importFile(write("lying.fbx", with("UpAxis", "1", "0", with("CoordAxis", "0", "1", whole)))), {4, 3, 3},
               "x up");
    write("inches.toml", "unit = 1\nup = \"z\"\n");
    expectSize(importFile(folder_ / "inches.fbx"), {300, 400, 300}, "the sidecar replaces both");
}

TEST_F(FileSpaces, threeMfIsInMillimetresUnlessItSaysOtherwise) {
    expectSize(importFile(kFixtures / "units/mm.3mf"), glm::dvec3(1, 2, 3) * 1e-3, "millimetres");
    expectSize(importFile(kFixtures / "units/inch.3mf"), glm::dvec3(1, 2, 3) * 0.0254, "inches");
    expectSize(importFile(kFixtures / "units/stored.3mf"), {1, 2, 3}, "metres, not compressed");
    EXPECT_LT(glm::length(worldBox(importFile(kFixtures / "units/stored.3mf")).lo - glm::dvec3(10, 20, 30)), 1e-5);
    const Scene parsecs = importFile(kFixtures / "units/parsec.3mf");
    expectSize(parsecs, glm::dvec3(1, 2, 3) * 1e-3, "no unit of the format");
    EXPECT_TRUE(hasNote(parsecs, "read as millimetres ('parsec')"));
}

TEST_F(FileSpaces, amfToo) {
    expectSize(amf("<amf>"), glm::dvec3(1, 2, 3) * 1e-3, "nothing said");
    expectSize(amf("<amf version='1.1' unit = 'inch'>"), glm::dvec3(1, 2, 3) * 0.0254, "inches");
    expectSize(amf("<amf\n  unit=\"meter\">"), {1, 2, 3}, "metres");
}

TEST_F(FileSpaces, x3dUnitsOfLength) {
    expectSize(x3d(""), {1, 3, 2}, "metres");
    expectSize(x3d("<head><unit category=\"angle\" name=\"d\" conversionFactor=\"0.0174533\"/><unit name='c' "
                   "conversionFactor='0.01' category='length'/></head>"),
               {0.01, 0.03, 0.02}, "centimetres");
    expectSize(x3d("<head><unit category=\"length\" conversionFactor=\"-1\"/></head>"), {1, 3, 2}, "nonsense");
}

TEST_F(FileSpaces, openGexMetrics) {
    expectSize(openGex(""), {1, 3, 2}, "nothing said");
    expectSize(openGex("Metric (key = \"distance\") {float {0.01}}\nMetric (key = \"up\") {string {\"z\"}}\n"),
               {0.01, 0.02, 0.03}, "centimetres, z");
    expectSize(openGex("Metric (key = \"up\") {string {\"y\"}}\nMetric (key = \"distance\") {float {2}}\n"), {2, 6, 4},
               "y");
}

TEST_F(FileSpaces, dxfUnits) {
    const auto header = [](int unit) {
        return fmt::format("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n 70\n{}\n0\nENDSEC\n", unit);
    };
    expectSize(dxf(""), {1, 2, 3}, "nothing said");
    expectSize(dxf(header(0)), {1, 2, 3}, "none");
    expectSize(dxf(header(4)), glm::dvec3(1, 2, 3) * 1e-3, "millimetres");
    expectSize(dxf(header(1)), glm::dvec3(1, 2, 3) * 0.0254, "inches");
    expectSize(dxf(header(99)), {1, 2, 3}, "unknown");
}

TEST_F(FileSpaces, colladaIsAssimps) {
    expectSize(importFile(kFixtures / "units/cmz.dae"), {0.01, 0.02, 0.03}, "centimetres, z up");
    expectSize(importFile(kFixtures / "units/mx.dae"), {2, 3, 1}, "x up");
}

TEST_F(FileSpaces, theSidecarKnowsSixDirections) {
    for (const auto& [up, size, top] : {std::tuple{"x", glm::dvec3(2, 3, 1), 1.0},
                                        {"-x", {2, 3, 1}, 0},
                                        {"y", {1, 3, 2}, 2},
                                        {"-y", {1, 3, 2}, 0},
                                        {"z", {1, 2, 3}, 3},
                                        {"-z", {1, 2, 3}, 0}}) {
        const Scene scene = ply(fmt::format("up = \"{}\"\n", up));
        expectSize(scene, size, up);
        EXPECT_EQ(worldBox(scene).hi.z, top) << up;
    }
    base::expectHolds(base::errorLine([&] { ply("up = \"--z\"\n"); }), "\"-z\"");
}

}  // namespace
}  // namespace dapple::scenegen
