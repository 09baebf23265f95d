#include "scenegen/export/obj.h"

#include "base/expect_error.h"
#include "base/image.h"
#include "scenegen/files.h"
#include "scenegen/library.h"

#include <algorithm>

namespace dapple::scenegen {
namespace {

const std::filesystem::path kFixtures = base::homeFolder() / "tests/fixtures";
const std::string kCard =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl leaf\nf 1/1 2/2 3/3 4/4\n";
const std::string kGround = "v 0 0 0\nv 9 0 0\nv 0 0 -9\nf -3 -2 -1\n";

/// RGBA, left half opaque, right half not; its grey level is the other way round.
base::Image8 halves(int width, int height) {
    base::Image8 image{width, height, 4, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const uint8_t opaque = x < width / 2 ? 255 : 0, grey = uint8_t(255 - opaque);
            image.texels.insert(image.texels.end(), {grey, grey, grey, opaque});
        }
    return image;
}

class Obj : public Files {
protected:
    /// A card whose material has these lines, and a ground that is always there.
    Scene card(const std::string& mtl) const {
        write("m.mtl", "newmtl leaf\nKd 1 1 1\n" + mtl);
        return importFile(
            write("card.obj", "mtllib m.mtl\n" + kGround +
                                  "o card\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n" +
                                  "usemtl leaf\nf -4/-4 -3/-3 -2/-2 -1/-1\n"));
    }
    static const Material* leaf(const Scene& scene) {
        for (const Material& m : scene.materials)
            if (m.name == "leaf") return &m;
        return nullptr;
    }
};

TEST_F(Obj, dAndTrAndTheirOrder) {
    struct Case {
        const char* lines;
        bool drawn, noted;
    };
    for (const Case& c : {Case{"d 0", false, false},
                          {"Tr 1", false, false},
                          {"d 1", true, false},
                          {"Tr 0", true, false},
                          {"d 0.4", false, true},
                          {"Tr 0.4", true, true},
                          {"d 1\nTr 1", true, false},
                          {"Tr 1\nd 1", true, false},
                          {"d -halo 0.2", false, true},
                          {"d .5", true, true},
                          {"D 0", false, false},
                          {"d nan", true, false}}) {
        const Scene scene = card(c.lines);
        EXPECT_EQ(scene.facts().triangles, c.drawn ? 3u : 1u) << c.lines;
        EXPECT_EQ(hasNote(scene, "opacities are cut at one half"), c.noted) << c.lines;
    }
}

TEST_F(Obj, masksCutOutWithOrWithoutAColour) {
    base::writePng(folder_ / "colour.png", {1, 1, 4, {10, 20, 30, 255}});
    base::writePng(folder_ / "alpha.png", halves(8, 4));
    base::Image8 grey = halves(8, 4);
    for (size_t i = 3; i < grey.texels.size(); i += 4) grey.texels[i] = 255;
    base::writePng(folder_ / "grey.png", grey);
    struct Case {
        const char* lines;
        bool leftOpaque;
    };
    for (const Case& c : {Case{"map_d grey.png", false},
                          {"map_Kd colour.png\nmap_d grey.png", false},
                          {"map_Kd colour.png\nmap_d alpha.png", true},
                          {"map_Kd alpha.png", true},
                          {"map_Kd alpha.png\nmap_d alpha.png", true},
                          {"map_Kd colour.png\nmap_d -imfchan r alpha.png", false},
                          {"map_d -imfchan m alpha.png", true}}) {
        const Scene scene = card(c.lines);
        ASSERT_NE(leaf(scene), nullptr) << c.lines;
        EXPECT_TRUE(leaf(scene)->alphaTested) << c.lines;
        const base::Image8& image = scene.textures.at(size_t(leaf(scene)->texture)).image;
        ASSERT_EQ(image.width, 8) << "the mask keeps its edges: " << c.lines;
        EXPECT_EQ(image.at(0, 0)[3] >= 128, c.leftOpaque) << c.lines;
        EXPECT_EQ(image.at(7, 0)[3] >= 128, !c.leftOpaque) << c.lines;
    }
}

TEST_F(Obj, opacityTimesTextureMovesTheCutOff) {
    base::Image8 image{2, 1, 4, {255, 255, 255, 150, 255, 255, 255, 255}};  // 150 / 255 = 0.59
    base::writePng(folder_ / "t.png", image);
    EXPECT_FALSE(leaf(card("map_Kd t.png"))->alphaTested);
    const Scene scene = card("map_Kd t.png\nd 0.8");
    EXPECT_TRUE(leaf(scene)->alphaTested);
    EXPECT_FLOAT_EQ(leaf(scene)->alphaCutoff, 0.625f);
    EXPECT_EQ(leaf(card("map_Kd t.png\nd 0.49")), nullptr);
}

TEST_F(Obj, optionsOfMapsAreFollowedOrNoted) {
    base::writePng(folder_ / "a b.png", {1, 1, 4, {255, 255, 255, 255}});
    const Scene scene = card("map_Kd -blendu on -s 2 3 1 -o .25 -0.5 -clamp on -bm 1 a b.png");
    ASSERT_GE(leaf(scene)->texture, 0);
    const Texture& texture = scene.textures.at(size_t(leaf(scene)->texture));
    EXPECT_TRUE(texture.wrapU == Wrap::clamp && texture.wrapV == Wrap::clamp);
    for (const Prototype& p : scene.prototypes)
        for (const Mesh& m : p.meshes)
            for (size_t v = 0; v < m.uvs.size(); ++v) {
                EXPECT_FLOAT_EQ(m.uvs[v].x, 2 * m.positions[v].x + 0.25f);
                EXPECT_FLOAT_EQ(m.uvs[v].y, 1 - (3 * m.positions[v].z - 0.5f));
            }
    EXPECT_TRUE(scene.notes.empty());
    EXPECT_TRUE(hasNote(card("map_Kd -t 1 1 1 a b.png"), "options of maps are ignored ('-t')"));
    EXPECT_TRUE(hasNote(card("map_Kd a b.png\nmap_d -s 2 2 2 a b.png"), "where map_Kd says otherwise"));
    EXPECT_TRUE(hasNote(card("map_Bump a b.png"), "'map_bump'"));
    EXPECT_TRUE(card("Ka 0 0 0\nKs 0 0 0\nNs 10\nillum 2\nNi 1.5").notes.empty());
}

TEST_F(Obj, librariesAndTexturesAreFoundWhereTheyAre) {
    base::writePng(folder_ / "Mats/Leaf.png", halves(4, 4));
    write("Mats/My Leaves.mtl", "\xef\xbb\xbfnewmtl leaf\r\nmap_Kd leaf.PNG\r\n");
    write("other.mtl", "newmtl other\n");
    for (const char* line : {"mtllib Mats/My Leaves.mtl", "mtllib mats\\MY LEAVES.MTL",
                             "\xef\xbb\xbfmtllib Mats/My Leaves.mtl\r", "mtllib other.mtl\nmtllib Mats/My Leaves.mtl",
                             "mtllib \\\n Mats/My Leaves.mtl", "mtllib   Mats/My Leaves.mtl  # leaves"}) {
        const Scene scene = importFile(write("x.obj", std::string(line) + "\n" + kCard));
        EXPECT_TRUE(scene.facts().alphaTested) << line;
        EXPECT_TRUE(scene.notes.empty()) << line << ": " << scene.notes.at(0);
    }
    write("two.mtl", "newmtl leaf\nKd 1 0 0\n");
    EXPECT_EQ(importFile(write("x.obj", "mtllib other.mtl two.mtl\n" + kCard)).materials.at(0).albedo,
              glm::vec3(1, 0, 0));
}

TEST_F(Obj, aNumberSignMayBeOfAName) {
    base::writePng(folder_ / "leaf #2.png", halves(4, 4));
    write("m#1.mtl", "# made by hand\nnewmtl Material #25 # of a leaf\nmap_Kd leaf #2.png\n");
    std::string card = kCard;
    card.replace(card.find("usemtl leaf"), 11, "usemtl Material #25");
    card.replace(card.rfind('\n'), 1, " #one face\n#the end");
    const Scene scene = importFile(write("x.obj", "  # a card\nmtllib m#1.mtl\n" + card));
    EXPECT_TRUE(scene.facts().alphaTested && scene.notes.empty());
}

TEST_F(Obj, whatIsNotFoundIsNamed) {
    const Scene scene = importFile(write("x.obj", "mtllib gone.mtl\n" + kCard));
    EXPECT_TRUE(hasNote(scene, "material libraries are not found, and their materials are grey ('gone.mtl')"));
    write("x.mtl", "newmtl leaf\nKd 0 1 0\n");
    EXPECT_TRUE(hasNote(importFile(folder_ / "x.obj"), "named like the scene is read ('gone.mtl')"));
    write("there.mtl", "newmtl bark\n");
    EXPECT_TRUE(
        hasNote(importFile(write("y.obj", "mtllib there.mtl\n" + kCard)), "in no library and are grey ('leaf')"));
    EXPECT_TRUE(hasNote(card("map_Kd gone.png"),
                        "textures are not found, and their materials have flat colours without holes ('gone.png')"));
    EXPECT_TRUE(hasNote(card("map_d gone.png"), "('gone.png')"));
}

TEST_F(Obj, texturesThatCannotBeDecodedAreNamed) {
    write("leaf.ktx2", "\xabKTX 20\xbb\r\n\x1a\n and so on");
    write("leaf.dds", "DDS |");
    write("cut.png", "\x89PNG\r\n\x1a\n");
    for (const char* name : {"leaf.ktx2", "leaf.dds", "cut.png"}) {
        const Scene scene = card(fmt::format("map_Kd {}", name));
        EXPECT_TRUE(hasNote(scene, "and their materials have flat colours without holes")) << name;
        EXPECT_TRUE(hasNote(scene, fmt::format("('{}')", name)));
        EXPECT_EQ(leaf(scene)->texture, -1);
    }
}

TEST_F(Obj, nothingOutsideItsFolderIsRead) {
    base::writePng(folder_ / "secret.png", halves(4, 4));
    write("secret.mtl", "newmtl leaf\nKd 1 0 0\n");
    const std::string absolute = (folder_ / "secret.mtl").string();
    write("in/m.mtl", "newmtl leaf\nmap_Kd ../secret.png\n");
    std::filesystem::create_symlink(folder_ / "secret.mtl", folder_ / "in/link.mtl");
    for (const std::string& name :
         {std::string("../secret.mtl"), absolute, std::string("link.mtl"), std::string("m.mtl")}) {
        const Scene scene = importFile(write("in/x.obj", "mtllib " + name + "\n" + kCard));
        EXPECT_TRUE(hasNote(scene, "files outside the scene's folder are not read")) << name;
        EXPECT_TRUE(scene.textures.empty() && scene.materials.at(0).albedo != glm::vec3(1, 0, 0)) << name;
    }
}

TEST(ObjFixtures, georeferencedCoordinatesKeepTheirShape) {
    for (const char* name : {"near.obj", "rd.obj", "utm.obj"}) {
        const Scene scene = importFile(kFixtures / "georeferenced" / name);
        EXPECT_EQ(scene.facts().triangles, 254u) << name;
        EXPECT_NEAR(area(scene), 1799.6, 0.05) << name;
        EXPECT_NEAR(worldBox(scene).size().x, 40, 1e-4) << name;
    }
    const base::DBox box = worldBox(importFile(kFixtures / "georeferenced/utm.obj"));
    EXPECT_NEAR(box.lo.x, 500103.37, 1e-4);
    EXPECT_NEAR(box.hi.y, 5412365.62, 1e-4);
    EXPECT_NEAR(box.lo.z, 412.3, 1e-4);
}

TEST_F(Obj, farCoordinatesKeepTheirShapeInEveryUnitAndOfManyObjects) {
    // A thousand steps of 0.125 m, in objects of ten: too many to stay apart.
    std::string obj;
    for (int i = 0; i < 1000; ++i) {
        if (i % 10 == 0) obj += fmt::format("o flight{}\n", i / 10);
        for (const glm::dvec3 d : {glm::dvec3(0, 0, 0), {1, 0, 0}, {1, 0, -0.125}, {0, 0, -0.125}})
            obj += fmt::format("v {} {} {}\n", 3512345.5 + d.x, 0.125 * i, -5812345.25 - 0.125 * i + d.z);
        obj += "f -4 -3 -2 -1\n";
    }
    const Scene scene = importFile(write("stairs.obj", obj));
    EXPECT_EQ(scene.facts().triangles, 2000u);
    EXPECT_NEAR(area(scene), 125, 1e-3);
    write("stairs.toml", "unit = 0.01\nup = \"z\"\n");
    const Scene small = importFile(folder_ / "stairs.obj");
    EXPECT_NEAR(area(small), 125e-4, 1e-5);
    EXPECT_NEAR(worldBox(small).lo.x, 35123.455, 1e-4);
}

TEST_F(Obj, facesOfEveryFormAndErrorsInOneLine) {
    const std::string v = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
    for (const char* face : {"f 1 2 3 4", "f 1/1 2/1 3/1 4/1", "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/1/1 3/1/1 4/1/1",
                             "f -4 -3 -2 -1", "f 1 2 \\\n 3 4", "f 1 2 3 4 # a face", "f 1/ 2/ 3/ 4/", "f 1 1 2 3 4 4"})
        EXPECT_NEAR(area(importFile(write("f.obj", v + face + "\n"))), 1, 1e-6) << face;
    EXPECT_NEAR(area(importFile(write("f.obj", "v +1e1 0 0 1 0 0\nv 1.1e+1 0 0 1 0 0\nv 11 1 0 1 0 0\nf 1 2 3"))), 0.5,
                1e-6)
        << "colours, signs, no end of line";
    EXPECT_NEAR(area(importFile(write("f.obj", "v 0 0 0 2\nv 2 0 0 2\nv 2 2 0 2\nf 1 2 3"))), 0.5, 1e-6)
        << "homogeneous";
    for (const auto& [face, part] : {std::pair{"f 1 2 9", "vertex 9 of 4"},
                                     {"f 1 2 -9", "vertex"},
                                     {"f 1 2 x", "no index"},
                                     {"f 0 1 2", "vertex 0 of 4"},
                                     {"f 1 2 99999999999999999999", "no index"},
                                     {"l 1 2", "no triangle"},
                                     {"curv 0 1 1 2", "no triangle"}})
        base::expectHolds(base::errorLine([&] { importFile(write("f.obj", v + face + "\n")); }), part);
    base::expectHolds(base::errorLine([&] {
                          importFile(write("f.obj", "v 0 0 0\nv 3e38 0 0\nv 0 3e38 0\nv 1e999 0 0\no far\nf 1 2 4\n"));
                      }),
                      "node 'far': vertex 4 is not finite");
}

TEST_F(Obj, groupsThatComeBackGoOnAndObjectsStayApart) {
    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n",
                      other = "v 0 0 5\nv 1 0 5\nv 0 1 6\nf -3 -2 -1\n";
    EXPECT_EQ(
        importFile(write("g.obj", "g wall\n" + triangle + "g roof\n" + other + "g wall\n" + other)).instances.size(),
        2u);
    EXPECT_EQ(importFile(write("o.obj", "o a\n" + triangle + "o b\n" + triangle + "o a\n" + triangle)).instances.size(),
              3u);
}

TEST_F(Obj, aRoundTripKeepsColoursAndHoles) {
    for (const char* name : {"city-vienna", "forest-small", "sphere"}) {
        const Scene scene = loadScene(name, {"scale=0.01"});
        const std::filesystem::path path = folder_ / (std::string(name) + ".obj");
        writeObj(scene, path);
        const Scene back = importFile(path);
        EXPECT_TRUE(back.notes.empty()) << back.notes.at(0);
        for (const Material& m : back.materials) {
            // Equal materials are merged, so that the name is that of the first.
            const size_t index = std::stoul(m.name.substr(m.name.rfind('_') + 1));
            const Material& was = scene.materials.at(index);
            for (int i = 0; i < 3; ++i) EXPECT_NEAR(m.albedo[i], was.albedo[i], 1e-5) << m.name;
            EXPECT_EQ(m.alphaTested, was.alphaTested) << m.name;
            EXPECT_FLOAT_EQ(m.specular, was.shininess >= 1 ? was.specular : 0) << m.name;
        }
    }
}

TEST_F(Obj, aRoundTripKeepsCutOffsAndClampedTextures) {
    Scene scene = loadScene("sphere");
    scene.textures.push_back({"mask", halves(4, 4), Wrap::clamp, Wrap::clamp});
    Material& m = scene.materials[scene.prototypes[0].meshes[0].material];
    m.texture = 0, m.alphaTested = true, m.alphaCutoff = 0.8f;
    for (Mesh& mesh : scene.prototypes[0].meshes) mesh.uvs.resize(mesh.positions.size(), glm::vec2(0.25f));
    writeObj(scene, folder_ / "s.obj");
    const Scene back = importFile(folder_ / "s.obj");
    const auto it = std::ranges::find_if(back.materials, [](const Material& k) { return k.alphaTested; });
    ASSERT_NE(it, back.materials.end());
    EXPECT_NEAR(it->alphaCutoff, 0.8f, 1e-5);
    EXPECT_EQ(back.textures.at(size_t(it->texture)).wrapU, Wrap::clamp);
}

}  // namespace
}  // namespace dapple::scenegen
