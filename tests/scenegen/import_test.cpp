#include "scenegen/import/import.h"

#include "base/error.h"
#include "base/file.h"
#include "base/image.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>

namespace dapple::scenegen {
namespace {
namespace fs = std::filesystem;

const fs::path kFixtures = base::homeFolder() / "tests/fixtures";

std::string base64(std::string_view bytes) {
    static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t word = 0;
        for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[word >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

/// A glTF with one mesh, the tetrahedron (0,0,0) (1,0,0) (0,1,0) (0,0,1), y up, and the given nodes.
std::string tetrahedronGltf(const std::vector<std::string>& nodes) {
    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint16_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    std::string bytes(sizeof positions + sizeof indices, 0);
    std::memcpy(bytes.data(), positions, sizeof positions);
    std::memcpy(bytes.data() + sizeof positions, indices, sizeof indices);
    std::string list, roots;
    for (size_t i = 0; i < nodes.size(); ++i) {
        list += fmt::format("{}{{\"mesh\":0,{}}}", i ? "," : "", nodes[i]);
        roots += fmt::format("{}{}", i ? "," : "", i);
    }
    return fmt::format(R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],"nodes":[{}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "buffers":[{{"byteLength":72,"uri":"data:application/octet-stream;base64,{}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":24}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
                     {{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}}]}})",
                       roots, list, base64(bytes));
}

double signedVolume(const Prototype& prototype) {
    double sum = 0;
    for (const Mesh& mesh : prototype.meshes)
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const glm::dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]), c(mesh.positions[mesh.indices[i + 2]]);
            sum += glm::dot(a, glm::cross(b, c)) / 6;
        }
    return sum;
}

/// World box of everything, origin included.
base::DBox worldBox(const Scene& scene) {
    const base::Box box = scene.facts().box;
    return {glm::dvec3(box.lo) + scene.origin, glm::dvec3(box.hi) + scene.origin};
}

class Import : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() / fmt::format("dapple_import_{}_{}", ::getpid(), test->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path write(const std::string& name, std::string_view text) const {
        base::writeFile(folder_ / name, text);
        return folder_ / name;
    }
    Scene gltf(const std::vector<std::string>& nodes) const { return importFile(write("t.gltf", tetrahedronGltf(nodes))); }
    static void expectUsageError(const fs::path& file, std::vector<std::string> parts) {
        parts.push_back(file.filename().string());
        try {
            importFile(file);
            FAIL() << "no error for " << file;
        } catch (const base::UsageError& error) {
            const std::string what = error.what();
            for (const std::string& part : parts) EXPECT_NE(what.find(part), std::string::npos) << what << "\nlacks: " << part;
            EXPECT_EQ(what.find('\n'), std::string::npos) << what;
        }
    }

    fs::path folder_;
};

TEST_F(Import, ObjIsYUpAndItsBoxIsClosed) {
    const Scene scene = importFile(kFixtures / "hut.obj");
    const Facts facts = scene.facts();
    EXPECT_EQ(facts.triangles, 14u);
    const base::DBox box = worldBox(scene);
    EXPECT_EQ(box.lo, glm::dvec3(-20, -20, 0));
    EXPECT_EQ(box.hi, glm::dvec3(20, 20, 2.5));
    ASSERT_EQ(scene.prototypes.size(), 2u);
    for (const Prototype& p : scene.prototypes) {
        EXPECT_EQ(p.closed, p.triangles() == 12) << p.name;
        if (p.closed) {
            EXPECT_NEAR(signedVolume(p), 30, 1e-4);
        }
    }
    for (const Material& m : scene.materials) EXPECT_FALSE(m.alphaTested);
}

TEST_F(Import, NodesThatShareAMeshBecomeInstances) {
    // Turned 90° about the file's vertical and scaled by 2: a similarity about the vertical.
    const Scene scene = gltf({R"("name":"a","translation":[10,0,0],"rotation":[0,0.70710678,0,0.70710678],"scale":[2,2,2])",
                              R"("name":"b","translation":[0,0,-5])"});
    ASSERT_EQ(scene.prototypes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 2u);
    const Instance &a = scene.instances[0], &b = scene.instances[1];
    EXPECT_NEAR(a.scale, 2, 1e-6);
    EXPECT_NEAR(a.yaw, glm::half_pi<float>(), 1e-6);
    EXPECT_NEAR(glm::distance(a.translation, glm::vec3(10, 0, 0)), 0, 1e-6);
    EXPECT_EQ(b.scale, 1);
    EXPECT_EQ(b.yaw, 0);
    EXPECT_NEAR(glm::distance(b.translation, glm::vec3(0, 5, 0)), 0, 1e-6);  // glTF's -z is our north
    EXPECT_TRUE(scene.prototypes[0].closed);
    EXPECT_NEAR(signedVolume(scene.prototypes[0]), 1.0 / 6, 1e-6);
    const Facts facts = scene.facts();
    EXPECT_TRUE(facts.rotated && facts.scaled && facts.closed);
}

TEST_F(Import, CopiesOfAMeshAreFoundByContent) {
    const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 0 -1\nv 0 1 0\no a\nf 1 2 3 \no b\nf 1 2 3\n";
    const Scene scene = importFile(write("twice.obj", obj));
    EXPECT_EQ(scene.prototypes.size(), 1u);
    EXPECT_EQ(scene.instances.size(), 2u);
}

TEST_F(Import, OtherTransformsAreBaked) {
    const Scene scene = gltf({R"("translation":[0,0,0],"scale":[1,3,1])", R"("translation":[9,0,0],"scale":[1,3,1])",
                              R"("translation":[5,0,0],"scale":[-1,1,1])", R"("translation":[0,7,0])"});
    ASSERT_EQ(scene.prototypes.size(), 3u);  // stretched (twice), mirrored, as it is
    ASSERT_EQ(scene.instances.size(), 4u);
    EXPECT_EQ(scene.instances[0].prototype, scene.instances[1].prototype);
    double volume = 0;
    for (const Instance& i : scene.instances) {
        const Prototype& p = scene.prototypes[i.prototype];
        EXPECT_TRUE(p.closed);
        volume += signedVolume(p) * std::pow(double(i.scale), 3);
    }
    EXPECT_NEAR(volume, (3 + 3 + 1 + 1) / 6.0, 1e-5);  // positive: mirroring has not turned triangles inside out
    const base::DBox box = worldBox(scene);
    EXPECT_NEAR(glm::distance(box.lo, glm::dvec3(0, -1, 0)), 0, 1e-5);
    EXPECT_NEAR(glm::distance(box.hi, glm::dvec3(10, 0, 8)), 0, 1e-5);
}

TEST_F(Import, NormalsPointOutwards) {
    const Scene scene = gltf({R"("scale":[-1,2,1])"});
    for (const Mesh& mesh : scene.prototypes.at(0).meshes)
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const glm::vec3 a = mesh.positions[mesh.indices[i]];
            const glm::vec3 n = glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a);
            for (size_t k = 0; k < 3; ++k) EXPECT_GT(glm::dot(glm::normalize(n), mesh.normals[mesh.indices[i + k]]), 0.3f);
        }
}

TEST_F(Import, FarCoordinatesGoIntoTheOrigin) {
    const Scene scene = importFile(write("far.obj", "v 4000100 0 -2000000\nv 4000200 0 -2000000\nv 4000100 0 -2000100\nf 1 2 3\n"));
    EXPECT_LT(glm::length(scene.instances.at(0).translation), 1000);
    EXPECT_LT(glm::length(scene.prototypes.at(0).box().hi), 1000);
    const base::DBox box = worldBox(scene);
    EXPECT_EQ(box.lo, glm::dvec3(4000100, 2000000, 0));
    EXPECT_EQ(box.hi, glm::dvec3(4000200, 2000100, 0));
}

TEST_F(Import, ManyStaticMeshesAreMergedByMaterialInCells) {
    std::string obj = "mtllib m.mtl\n";
    write("m.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    for (int i = 0; i < 300; ++i) {  // a row of 600 m of different triangles
        obj += fmt::format("o t{0}\nv {1} 0 0\nv {2} 0 0\nv {1} {3} 0\nusemtl {4}\nf -3 -2 -1\n", i, 2 * i, 2 * i + 1, 1 + 0.01 * i, i % 2 ? "red" : "blue");
    }
    const Scene scene = importFile(write("row.obj", obj));
    EXPECT_EQ(scene.facts().triangles, 300u);
    EXPECT_EQ(scene.prototypes.size(), 5u);  // ceil(600 m / 128 m)
    double area = 0;
    for (const Prototype& p : scene.prototypes) {
        EXPECT_EQ(p.meshes.size(), 2u);
        EXPECT_LE(p.box().size().x, 129);
        for (const Mesh& mesh : p.meshes)
            for (size_t i = 0; i < mesh.indices.size(); i += 3)
                area += double(glm::length(glm::cross(mesh.positions[mesh.indices[i + 1]] - mesh.positions[mesh.indices[i]],
                                                      mesh.positions[mesh.indices[i + 2]] - mesh.positions[mesh.indices[i]]))) / 2;
    }
    EXPECT_NEAR(area, 0.5 * (300 + 0.01 * 299 * 300 / 2), 1e-2);
    EXPECT_NEAR(worldBox(scene).hi.x, 599, 1e-3);
}

TEST_F(Import, AlphaTestingIsDerivedFromTheTexels) {
    const auto alphaTested = [&](int holes) {
        base::Image8 image{100, 100, 4, std::vector<uint8_t>(40000, 255)};
        for (int i = 0; i < holes; ++i) image.texels[size_t(i) * 4 + 3] = 127;
        base::writePng(folder_ / "leaf.png", image);
        write("m.mtl", "newmtl leaf\nKd 1 1 1\nmap_Kd leaf.png\n");
        const Scene scene = importFile(write("leaf.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl leaf\nf 1/1 2/2 3/3\n"));
        EXPECT_EQ(scene.textures.size(), 1u);
        return scene.facts().alphaTested;
    };
    EXPECT_FALSE(alphaTested(10));  // exactly one in a thousand
    EXPECT_TRUE(alphaTested(11));
}

TEST_F(Import, TextureCoordinatesGrowDownwards) {
    base::writePng(folder_ / "t.png", {2, 2, 4, std::vector<uint8_t>(16, 255)});
    write("m.mtl", "newmtl t\nmap_Kd sub\\T.PNG\n");  // Windows path, other case: still found
    const Scene scene = importFile(write("t.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl t\nf 1/1 2/2 3/3\n"));
    ASSERT_EQ(scene.textures.size(), 1u);
    const Mesh& mesh = scene.prototypes.at(0).meshes.at(0);
    for (size_t v = 0; v < mesh.positions.size(); ++v) EXPECT_NEAR(mesh.uvs[v].y, 1 - mesh.positions[v].z, 1e-6);
}

TEST_F(Import, MissingTextureBecomesAFlatColourWithOneWarning) {
    write("m.mtl", "newmtl t\nKd 0 1 0\nmap_Kd gone.png\n");
    ::testing::internal::CaptureStderr();
    const Scene scene = importFile(write("t.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl t\nf 1/1 2/2 3/3\n"));
    const std::string text = ::testing::internal::GetCapturedStderr();
    EXPECT_NE(text.find("textures are not found"), std::string::npos) << text;
    EXPECT_EQ(scene.materials.at(0).texture, -1);
    EXPECT_EQ(scene.materials.at(0).albedo, glm::vec3(0, 1, 0));
}

TEST_F(Import, DegenerateTrianglesAreDroppedAndCounted) {
    ::testing::internal::CaptureStderr();
    const Scene scene = importFile(write("d.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n"));
    const std::string text = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(scene.facts().triangles, 1u);
    EXPECT_NE(text.find("degenerate triangles are dropped (2 times)"), std::string::npos) << text;
}

TEST_F(Import, ChosenViewsStandOnTheGroundAndSeeTheScene) {
    const Scene scene = importFile(kFixtures / "hut.obj");
    ASSERT_GE(scene.views.size(), 4u);
    const glm::dvec3 hut = glm::dvec3(0, 0, 1.25) - scene.origin;
    size_t ground = 0;
    for (const View& view : scene.views) {
        EXPECT_NEAR(glm::length(view.forward), 1, 1e-12);
        EXPECT_GT(glm::dot(view.forward, glm::normalize(hut - view.eye)), 0.8) << view.name;
        EXPECT_GT(view.far, glm::distance(view.eye, hut));
        if (view.name.starts_with("auto")) {
            ++ground;
            EXPECT_NEAR(view.eye.z + scene.origin.z, 1.7, 1e-3);
        }
    }
    EXPECT_GE(ground, 3u);
    EXPECT_NO_THROW(scene.viewIndex("auto0"));
    EXPECT_NO_THROW(scene.viewIndex("above"));
    EXPECT_EQ(scene.sun.azimuth, 135);
    EXPECT_EQ(scene.sun.elevation, 45);
    EXPECT_EQ(scene.contentHash(), importFile(kFixtures / "hut.obj").contentHash());
}

TEST_F(Import, SidecarOverrides) {
    const fs::path file = write("s.gltf", tetrahedronGltf({R"("name":"keep","translation":[0,0,100])", R"("name":"BB_1","translation":[5,0,0])",
                                                          R"("name":"ground","translation":[9,0,0],"scale":[1,3,1])"}));
    write("s.toml", "up = \"z\"\nunit = 0.01\ndrop = [\"BB_*\"]\nreceivers = [\"gro*\"]\n[sun]\nazimuth = 90\nelevation = 10\n"
                    "[[copy]]\nnode = \"BB_1\"\nto = [1, 2, 3]\nyaw = 90\n"
                    "[[view]]\nname = \"near\"\neye = [1, 2, 3]\ntarget = [1, 5, 3]\n");
    const Scene scene = importFile(file);
    ASSERT_EQ(scene.prototypes.size(), 2u);
    EXPECT_TRUE(scene.prototypes[0].castsShadow);
    EXPECT_FALSE(scene.prototypes[1].castsShadow);
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_NEAR(scene.instances[0].translation.z, 1, 1e-6);
    EXPECT_NEAR(glm::distance(scene.instances[1].translation, glm::vec3(1, 2, 3)), 0, 1e-6);
    EXPECT_NEAR(scene.instances[1].yaw, glm::half_pi<float>(), 1e-6);
    EXPECT_EQ(scene.sun.azimuth, 90);
    ASSERT_EQ(scene.views.size(), 1u);
    EXPECT_EQ(scene.views[0].forward, glm::dvec3(0, 1, 0));
}

TEST_F(Import, SidecarIsReadStrictly) {
    const fs::path file = write("s.gltf", tetrahedronGltf({R"("name":"a")"}));
    for (const auto& [text, part] : {std::pair{"uq = \"z\"\n", "uq"}, {"up = \"w\"\n", "up"}, {"unit = 0\n", "unit"}, {"[sun]\nazimut = 3\n", "azimut"},
                                     {"[[view]]\nname = \"v\"\neye = [0,0,0]\ntarget = [0,0,0]\n", "target"}}) {
        write("s.toml", text);
        try {
            importFile(file);
            FAIL() << text;
        } catch (const base::UsageError& error) {
            EXPECT_NE(std::string(error.what()).find("s.toml"), std::string::npos) << error.what();
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    }
    write("s.toml", "[[copy]]\nnode = \"gone\"\nto = [0, 0, 0]\n");
    expectUsageError(file, {"gone"});
}

TEST_F(Import, CamerasAndSunOfTheFileAreUsed) {
    const std::string dae = R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Y_UP</up_axis></asset>
<library_cameras><camera id="c"><optics><technique_common><perspective><yfov>40</yfov><znear>1</znear><zfar>9</zfar></perspective></technique_common></optics></camera></library_cameras>
<library_lights><light id="l"><technique_common><directional><color>1 1 1</color></directional></technique_common></light></library_lights>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" name="n"><matrix>MATRIX</matrix><instance_geometry url="#g"/></node>
<node id="cam" name="cam"><translate>1 2 3</translate><instance_camera url="#c"/></node>
<node id="sun" name="sun"><rotate>1 0 0 -30</rotate><instance_light url="#l"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
    const auto with = [&](const std::string& matrix) {
        std::string text = dae;
        return text.replace(text.find("MATRIX"), 6, matrix);
    };
    const Scene scene = importFile(write("c.dae", with("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1")));
    ASSERT_EQ(scene.views.size(), 1u);
    EXPECT_NEAR(glm::distance(scene.views[0].eye, glm::dvec3(1, -3, 2)), 0, 1e-5);
    EXPECT_NEAR(glm::distance(scene.views[0].forward, glm::dvec3(0, 1, 0)), 0, 1e-5);  // COLLADA looks along -z
    // Light along -z, tilted 30° down: it comes from the south (+z), 30° high.
    EXPECT_NEAR(scene.sun.azimuth, 180, 1e-3);
    EXPECT_NEAR(scene.sun.elevation, 30, 1e-3);
    expectUsageError(write("nan.dae", with("nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1")), {"node 'n'", "finite"});
}

TEST_F(Import, CameraAngleIsTheVerticalOne) {
    std::string text = tetrahedronGltf({R"("camera":0,"name":"eye","translation":[0,0,9])"});
    text.insert(1, R"("cameras":[{"type":"perspective","perspective":{"yfov":0.7,"aspectRatio":1.5,"znear":0.1}}],)");
    const Scene scene = importFile(write("camera.gltf", text));
    ASSERT_EQ(scene.views.size(), 1u);
    EXPECT_NEAR(scene.views[0].fovY, glm::degrees(0.7), 1e-4);
    EXPECT_NEAR(glm::distance(scene.views[0].eye, glm::dvec3(0, -9, 0)), 0, 1e-5);
}

TEST_F(Import, BadFilesAreNamed) {
    expectUsageError(folder_ / "gone.obj", {"no such file"});
    expectUsageError(folder_, {"folder"});
    expectUsageError(write("empty.gltf", ""), {"empty"});
    expectUsageError(write("noise.glb", std::string(3000, '\x5a')), {"cannot be read"});
    expectUsageError(write("words.txt", "not a scene\n"), {"cannot be read"});
    const std::string whole = tetrahedronGltf({R"("name":"a")"});
    expectUsageError(write("cut.gltf", whole.substr(0, whole.size() / 2)), {"cannot be read"});
    expectUsageError(write("points.obj", "v 0 0 0\nv 1 0 0\n"), {});
    expectUsageError(write("line.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"), {"triangle"});
    expectUsageError(write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), {"triangle"});
    expectUsageError(write("nan.obj", "o hill\nv 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"), {"hill", "finite"});
    expectUsageError(write("huge.gltf", tetrahedronGltf({R"("name":"tower","translation":[1e39,0,0])"})), {"tower", "finite"});
}

TEST(RealScenes, UnknownOrUnfetchedNamesSayWhatToDo) {
    EXPECT_TRUE(isRealScene("forza"));
    EXPECT_FALSE(isRealScene("monza"));
    EXPECT_EQ(listRealScenes().size(), 3u);
    EXPECT_STREQ(realSceneScript("forza").argument, "forza");
    for (const SceneEntry& scene : listRealScenes()) EXPECT_TRUE(fs::exists(base::homeFolder() / realSceneScript(scene.name).file));
    EXPECT_THROW(realSceneScript("monza"), base::UsageError);
    EXPECT_THROW(realScenePath("monza"), base::UsageError);
}

/// Triangle counts: measured once with Assimp 5.2.5 and an independent loader of the packages
/// torcs-data 1.3.7 and morse-simulator-data 1.4. Exact but for degenerate triangles, which we drop.
TEST(RealScenes, ForzaIsWhole) {
    const fs::path file = base::cacheFolder() / "real/forza/forza.ac";
    if (!fs::exists(file)) GTEST_SKIP() << "not fetched; run scenegen/import/fetch_real forza";
    const Scene scene = importFile(file);
    size_t alpha = 0;
    for (const Instance& i : scene.instances)
        for (const Mesh& mesh : scene.prototypes[i.prototype].meshes)
            if (scene.materials[mesh.material].alphaTested) alpha += mesh.triangles();
    EXPECT_NEAR(double(scene.facts().triangles), 71775, 0.001 * 71775);
    EXPECT_NEAR(double(alpha), 16906, 0.001 * 16906);
    EXPECT_EQ(scene.textures.size(), 129u);
    EXPECT_LT(scene.prototypes.size(), 200u);
    EXPECT_FALSE(scene.facts().closed);
    EXPECT_NO_THROW(scene.viewIndex("start"));
}

TEST(RealScenes, BuildingsAreWholeAndTheTreesInstances) {
    const fs::path file = base::cacheFolder() / "real/buildings/buildings_2.blend";
    if (!fs::exists(file)) GTEST_SKIP() << "not fetched; run scenegen/import/fetch_real buildings";
    const fs::path bare = fs::temp_directory_path() / fmt::format("dapple_bare_{}.blend", ::getpid());
    fs::copy_file(file, bare, fs::copy_options::overwrite_existing);
    const Scene all = importFile(bare);  // without the sidecar: all that is in the file
    fs::remove(bare);
    EXPECT_NEAR(double(all.facts().triangles), 457946, 0.001 * 457946);
    const Scene scene = importFile(file);
    size_t trees = 0;
    for (const Instance& i : scene.instances) trees += scene.prototypes[i.prototype].triangles() == 29380;
    EXPECT_EQ(trees, 14u);
    EXPECT_LT(scene.facts().uniqueTriangles, 100'000u);
    EXPECT_LT(scene.facts().box.hi.z, 20);  // the sky box is gone
    EXPECT_NO_THROW(scene.viewIndex("village"));
}

}  // namespace
}  // namespace dapple::scenegen
