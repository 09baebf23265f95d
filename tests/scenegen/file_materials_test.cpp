#include "base/error.h"
#include "base/image.h"
#include "scenegen/files.h"
#include "scenegen/import/file_access.h"

#include <algorithm>

// Materials of formats that Assimp reads: AC3D, COLLADA and DirectX's .x.
namespace dapple::scenegen {
namespace {

class MaterialsOfFiles : public Files {
protected:
    /// A square of 1 m² with this transparency and texture, beside one of 4 m² without.
    Scene ac3d(double transparency, const std::string& texture) const {
        const auto material = [](double trans) {
            return fmt::format("MATERIAL \"m\" rgb .5 .5 .5 amb 0 0 0 emis 0 0 0 spec 0 0 0 shi 0 trans {}\n", trans);
        };
        const auto square = [](int index, int at, int size, const std::string& with) {
            return fmt::format(
                "OBJECT poly\nname \"s{0}\"\n{1}numvert 4\n{2} 0 0\n{3} 0 0\n{3} {4} 0\n{2} {4} 0\nnumsurf 1\nSURF "
                "0x20\nmat {0}\n"
                "refs 4\n0 0 0\n1 1 0\n2 1 1\n3 0 1\nkids 0\n",
                index, with, at, at + size, size);
        };
        const std::string line = texture.empty() ? "" : "texture \"" + texture + "\"\n";
        return importFile(write("s.ac", "AC3Db\n" + material(transparency) + material(0) + "OBJECT world\nkids 2\n" +
                                            square(0, 0, 1, line) + square(1, 9, 2, "")));
    }
    Scene x(const std::string& texture) const {
        return importFile(
            write("t.x",
                  "xof 0303txt 0032\nMesh m {\n3;\n0;0;0;,\n1;0;0;,\n0;1;0;;\n1;\n3;0,1,2;;\nMeshTextureCoords "
                  "{\n3;\n0;0;,\n1;0;,\n0;1;;\n}\n"
                  "MeshMaterialList {\n1;\n1;\n0;;\nMaterial {\n1;1;1;1;;\n1;\n0;0;0;;\n0;0;0;;\nTextureFilename { \"" +
                      texture + "\"; }\n}\n}\n}\n"));
    }
};

TEST_F(MaterialsOfFiles, opacityIsCutAtOneHalf) {
    EXPECT_NEAR(area(ac3d(0, "")), 5, 1e-6);
    EXPECT_NEAR(area(ac3d(0.3, "")), 5, 1e-6);
    EXPECT_TRUE(hasNote(ac3d(0.3, ""), "opacities are cut at one half"));
    EXPECT_NEAR(area(ac3d(0.7, "")), 4, 1e-6);
    EXPECT_TRUE(hasNote(ac3d(0.7, ""), "opacities are cut at one half"));
}

TEST_F(MaterialsOfFiles, texturesAreFoundOrNamed) {
    base::Image8 image{2, 2, 4, std::vector<uint8_t>(16, 255)};
    image.at(1, 1)[3] = 0;
    base::writePng(folder_ / "maps/Leaf.png", image);
    base::writePng(folder_ / "Leaf.png", image);
    for (const char* name : {"leaf.PNG", "C:\\\\art\\\\leaf.png", "maps/leaf.png"}) {
        const Scene scene = x(name);
        EXPECT_TRUE(scene.facts().alphaTested) << name;
        EXPECT_TRUE(scene.notes.empty()) << name;
    }
    write("half.png", base::encodePng(image).substr(0, 30));
    write("leaf.webp", "RIFF....WEBP and no picture");
    EXPECT_TRUE(hasNote(x("gone.png"), "not found, and their materials have flat colours without holes ('gone.png')"));
    EXPECT_TRUE(hasNote(
        x("half.png"),
        "damaged or of no format that is read, and their materials have flat colours without holes ('half.png')"));
    EXPECT_TRUE(hasNote(x("leaf.webp"), "damaged or of no format that is read"));
    EXPECT_TRUE(hasNote(ac3d(0, "gone.png"), "('gone.png')"));
}

TEST_F(MaterialsOfFiles, texturesOutsideTheFolderAreNotRead) {
    base::writePng(folder_ / "secret.png", {1, 1, 4, {255, 255, 255, 255}});
    std::filesystem::create_directories(folder_ / "in");
    std::filesystem::create_symlink(folder_ / "secret.png", folder_ / "in/link.png");
    const std::string text = base::readFile((x("unused.png"), folder_ / "t.x"));
    for (const std::string& name :
         {std::string("../secret.png"), (folder_ / "secret.png").string(), std::string("link.png")}) {
        std::string other = text;
        other.replace(other.find("unused.png"), 10, name);
        const Scene scene = importFile(write("in/t.x", other));
        EXPECT_TRUE(hasNote(scene, "files outside the scene's folder are not read")) << name;
        EXPECT_TRUE(scene.textures.empty()) << name;
    }
    // Nor what a sidecar names, unless a person allows it.
    std::string other = text;
    write("in/t.x", other.replace(other.find("unused.png"), 10, "secret.png"));
    write("in/t.toml", "textures = [\"..\"]\n");
    EXPECT_THROW(importFile(folder_ / "in/t.x"), base::UsageError);
    allowOutside(true);
    EXPECT_EQ(importFile(folder_ / "in/t.x").textures.size(), 1u);
    allowOutside(false);
}

TEST_F(MaterialsOfFiles, hugeTexturesAreOneLine) {
    // A mask and a colour of 20,000 texels make one picture of 320 million.
    base::Image8 wide{16000, 1, 4, std::vector<uint8_t>(64000, 255)},
        high{1, 20000, 4, std::vector<uint8_t>(80000, 255)};
    base::writePng(folder_ / "wide.png", wide);
    base::writePng(folder_ / "high.png", high);
    write("m.mtl", "newmtl leaf\nmap_Kd wide.png\nmap_d high.png\n");
    const auto file = write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl leaf\nf 1/1 2/1 3/1\n");
    try {
        importFile(file);
        FAIL() << "nothing was thrown";
    } catch (const std::exception& error) {
        EXPECT_NE(std::string(error.what()).find("texels"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace dapple::scenegen
