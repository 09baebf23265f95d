#include "scenegen/gltf_maker.h"
#include "scenegen/export/glb.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numbers>

namespace dapple::scenegen {
namespace {

TEST(Gltf, InstancesOfTheExtensionAreAllThere) {
    const Scene scene = importFile(gltfFixtures() / "instancing/rows.gltf");
    EXPECT_EQ(scene.facts().triangles, 62u);
    EXPECT_EQ(scene.instances.size(), 6u);  // five boxes and the ground
    EXPECT_NEAR(boxOf(scene).hi.z, 6, 1e-6);
    EXPECT_TRUE(scene.notes.empty());
}

TEST(Gltf, QuantizedPositionsAreThoseOfTheBox) {
    for (const char* name : {"u16", "u16n", "i16n", "i8n"}) {
        SCOPED_TRACE(name);
        const Scene scene = importFile(gltfFixtures() / "quantized" / (std::string(name) + ".gltf"));
        EXPECT_EQ(scene.facts().triangles, 14u);
        const base::DBox box = boxOf(scene);
        EXPECT_NEAR(glm::distance(box.lo, glm::dvec3(-20, -20, 0)), 0, 1e-3);
        EXPECT_GT(box.hi.z, 1.9);
        EXPECT_LT(box.hi.z, 4.1);
    }
}

TEST(Gltf, ASkinStandsAtItsJointsNotAtItsNode) {
    const base::DBox right = boxOf(importFile(gltfFixtures() / "skin/control.gltf"));
    for (const char* name : {"ibm", "no_ibm"}) {
        const Scene scene = importFile(gltfFixtures() / "skin" / (std::string(name) + ".gltf"));
        base::Box box = instanceBox(scene.prototypes[1].box(), scene.instances[1]);
        EXPECT_NEAR(glm::distance(glm::dvec3(box.lo), glm::dvec3(6.5, -1.5, 0)), 0, 1e-5) << name;
        EXPECT_NEAR(glm::distance(glm::dvec3(box.hi), glm::dvec3(9.5, 1.5, 4)), 0, 1e-5) << name;
        EXPECT_NEAR(glm::distance(boxOf(scene).hi, right.hi), 0, 1e-5);
    }
}

TEST(Gltf, CamerasAreThoseOfTheirNodesWhateverTheNames) {
    const Scene clash = importFile(gltfFixtures() / "cameras/clash.gltf");
    ASSERT_EQ(clash.views.size(), 1u);
    EXPECT_NEAR(glm::distance(clash.views[0].eye + clash.origin, glm::dvec3(0, -20, 2)), 0, 1e-9);
    for (const auto& [name, second] : {std::pair{"two", "Camera 2"}, {"shared", "B"}}) {
        const Scene scene = importFile(gltfFixtures() / "cameras" / (std::string(name) + ".gltf"));
        ASSERT_EQ(scene.views.size(), 2u) << name;
        const View& view = scene.views[scene.viewIndex(second)];
        EXPECT_NEAR(glm::distance(view.eye + scene.origin, glm::dvec3(20, 0, 2)), 0, 1e-9);
        EXPECT_NEAR(glm::distance(view.forward, glm::dvec3(-1, 0, 0)), 0, 1e-9);
        EXPECT_EQ(noted(scene, "views of one name"), std::string(name) == "two");
    }
}

TEST(Gltf, ACameraKeepsItsPlanesAndAnOrthographicOneIsNamed) {
    Maker m;
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    m.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1.04719758}, {"znear", 0.300000012}, {"zfar", 90}}}},
                         {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 5}}}},
                         {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 2}}}}};
    for (const int camera : {0, 1, 2}) m.json["nodes"].push_back({{"camera", camera}, {"name", fmt::format("c{}", camera)}, {"translation", {0, 0, 5}}});
    m.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
    const Scene scene = m.read();
    ASSERT_EQ(scene.views.size(), 2u);
    EXPECT_EQ(scene.views[0].far, 90);
    EXPECT_EQ(scene.views[0].near, 0.3);  // what a float made of it is not the file's wish
    EXPECT_EQ(scene.views[0].fovY, 60);
    EXPECT_EQ(scene.views[1].near, 2);
    EXPECT_GT(scene.views[1].far, 5);  // chosen
    EXPECT_TRUE(noted(scene, "not perspective") && noted(scene, "'c1'"));
}

TEST(Gltf, EveryModeAndIndexTypeGivesTheSquare) {
    const std::vector<uint32_t> list{0, 1, 2, 2, 1, 3}, strip{0, 1, 2, 3}, fan{0, 1, 3, 2};
    for (const int bytes : {1, 2, 4})
        for (const auto& [mode, indices] : {std::pair{4, list}, {5, strip}, {6, fan}}) {
            SCOPED_TRACE(fmt::format("mode {}, {} bytes", mode, bytes));
            Maker m;
            const size_t at = bytes == 1 ? m.accessor(std::vector<uint8_t>(indices.begin(), indices.end()), "SCALAR", 1)
                              : bytes == 2 ? m.accessor(std::vector<uint16_t>(indices.begin(), indices.end()), "SCALAR", 1) : m.accessor(indices, "SCALAR", 1);
            m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"indices", at}, {"mode", mode}});
            const Scene scene = m.read();
            EXPECT_EQ(scene.facts().triangles, 2u);
            EXPECT_NEAR(areaOf(scene), 1, 1e-6);
            for (const glm::vec3& n : scene.prototypes[0].meshes[0].normals) EXPECT_NEAR(n.y, -1, 1e-6);  // the file's +z: all triangles turn one way
        }
    Maker soup;  // no indices at all
    soup.mesh({{"attributes", {{"POSITION", soup.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 9, 9, 9}, "VEC3", 3)}}}});
    const Scene scene = soup.read();
    EXPECT_NEAR(areaOf(scene), 1, 1e-6);
    EXPECT_TRUE(noted(scene, "make no triangle"));
}

TEST(Gltf, SparseAccessorsAreFilledIn) {
    for (const bool based : {true, false}) {
        Maker m;
        const size_t positions = m.square();
        if (!based) m.json["accessors"][positions].erase("bufferView");  // all 0 but for what follows
        const std::vector<float> values = based ? std::vector<float>{3, 3, 0} : std::vector<float>{1, 0, 0, 0, 1, 0, 3, 3, 0};
        const std::vector<uint8_t> places = based ? std::vector<uint8_t>{3} : std::vector<uint8_t>{1, 2, 3};
        m.json["accessors"][positions]["sparse"] = {{"count", places.size()}, {"indices", {{"bufferView", m.view(places)}, {"componentType", 5121}}},
                                                    {"values", {{"bufferView", m.view(values)}}}};
        m.mesh({{"attributes", {{"POSITION", positions}}}, {"mode", 5}});
        EXPECT_NEAR(areaOf(m.read()), 0.5 + 2.5, 1e-5);
    }
}

TEST(Gltf, MorphTargetsAreAppliedAtTheirWeights) {
    for (const bool ofNode : {false, true}) {
        Maker m;
        const size_t offsets = m.accessor<float>({0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 4, 0}, "VEC3", 3), shift = m.accessor<float>({5, 0, 0, 5, 0, 0, 5, 0, 0, 5, 0, 0}, "VEC3", 3);
        m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}, {"targets", {{{"POSITION", offsets}}, {{"POSITION", shift}}}}});
        m.json["meshes"][0]["weights"] = {0.25, 0};
        if (ofNode) m.json["nodes"][0]["weights"] = {0.5, 1};
        const Scene scene = m.read();
        EXPECT_NEAR(areaOf(scene), ofNode ? 3 : 2, 1e-5);
        EXPECT_NEAR(boxOf(scene).hi.x, ofNode ? 6 : 1, 1e-5);
    }
}

TEST(Gltf, ASkinBendsByTheMeanOfItsJoints) {
    Maker m;
    const size_t joints = m.accessor<uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", 4);
    const size_t weights = m.accessor<uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 102, 153, 0, 0, 0, 255, 0, 0}, "VEC4", 4, true);
    m.mesh({{"attributes", {{"POSITION", m.square()}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}}, {"mode", 5}});
    m.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}}, {{"name", "root"}, {"translation", {0, 1, 0}}, {"children", {2}}}, {{"name", "tip"}, {"translation", {0, 10, 0}}}};
    m.json["scenes"][0]["nodes"] = {0, 1};
    m.json["skins"] = {{{"joints", {1, 2}}}};
    const Scene scene = m.read();
    std::vector<double> heights;
    for (const glm::vec3& p : scene.prototypes[0].meshes[0].positions) heights.push_back(double(p.z) + scene.origin.z + double(scene.instances[0].translation.z));
    std::ranges::sort(heights);
    EXPECT_NEAR(heights.front(), 1, 1e-5);
    EXPECT_NEAR(heights.back(), 12, 1e-5);  // y = 1, carried by the tip alone
    EXPECT_TRUE(std::ranges::any_of(heights, [](double h) { return std::abs(h - (1 + 1 + 10 * 0.6)) < 1e-4; }));
    EXPECT_LT(boxOf(scene).hi.x, 2);
    m.json["skins"][0]["joints"] = {1};  // too few
    base::expectHolds(m.error(), "joint 1");
}

/// A textured square; texels with the given alphas side by side.
Maker cardOf(const std::vector<uint8_t>& alphas, const Json& material) {
    Maker m;
    base::Image8 image{int(alphas.size()), 1, 4, {}};
    for (const uint8_t a : alphas) image.texels.insert(image.texels.end(), {200, 100, 50, a});
    base::writePng(m.folder() / "t.png", image);
    m.mesh({{"attributes", {{"POSITION", m.square()}, {"TEXCOORD_0", m.accessor<float>({0, 1, 1, 1, 0, 0, 1, 0}, "VEC2", 2)}}}, {"mode", 5}, {"material", 0}});
    m.json["images"] = {{{"uri", "t.png"}}};
    m.json["textures"] = {{{"source", 0}}};
    m.json["materials"] = {material};
    return m;
}

Json materialOf(const char* mode, double cutoff, double factor) {
    Json m = {{"name", "m"}, {"alphaMode", mode}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {1, 1, 1, factor}}}}};
    if (cutoff >= 0) m["alphaCutoff"] = cutoff;
    return m;
}

TEST(Gltf, TheCutOutIsThatOfCutOffFactorAndTexture) {
    struct Case {
        const char* mode;
        double cutoff, factor;
        bool tested;
        float expected;
    };
    for (const Case& c : {Case{"OPAQUE", -1, 0.2, false, 0.5f}, {"MASK", -1, 1, true, 0.5f}, {"MASK", 0.1, 1, false, 0.5f}, {"MASK", 0.3, 1, true, 0.3f},
                          {"MASK", 0.3, 0.5, true, 0.6f}, {"BLEND", -1, 1, true, 0.5f}, {"BLEND", -1, 0.8, true, 0.625f}, {"MASK", 0, 0.5, false, 0.5f}}) {
        SCOPED_TRACE(fmt::format("{} {} {}", c.mode, c.cutoff, c.factor));
        Maker m = cardOf({51, 153, 255}, materialOf(c.mode, c.cutoff, c.factor));  // 0.2, 0.6, 1
        const Scene scene = m.read();
        ASSERT_EQ(scene.materials.size(), 1u);
        EXPECT_EQ(scene.materials[0].alphaTested, c.tested);
        if (c.tested) {
            EXPECT_FLOAT_EQ(scene.materials[0].alphaCutoff, c.expected);
        }
        EXPECT_EQ(noted(scene, "BLEND"), std::string(c.mode) == "BLEND");
    }
}

TEST(Gltf, WhatItsMaterialMakesInvisibleIsLeftOut) {
    for (const auto& [mode, cutoff, factor] : {std::tuple{"MASK", 0.5, 0.4}, {"BLEND", -1.0, 0.3}, {"MASK", 1.5, 1.0}}) {
        Maker m = cardOf({255}, materialOf(mode, cutoff, factor));
        base::expectHolds(m.error(), "no triangle");
        m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
        m.json["nodes"].push_back({{"mesh", 1}});
        m.json["scenes"][0]["nodes"] = {0, 1};
        const Scene scene = m.read();
        EXPECT_EQ(scene.facts().triangles, 2u);
        EXPECT_TRUE(noted(scene, "invisible"));
    }
}

TEST(Gltf, TexturesWrapAsTheirSamplersSay) {
    for (const auto& [s, t, u, v] : {std::tuple{10497, 33071, Wrap::repeat, Wrap::clamp}, {33648, 10497, Wrap::mirror, Wrap::repeat}, {33071, 33648, Wrap::clamp, Wrap::mirror}}) {
        Maker m = cardOf({0, 255}, materialOf("MASK", -1, 1));
        const uint64_t plain = m.read().contentHash();
        m.json["samplers"] = {{{"wrapS", s}, {"wrapT", t}}};
        m.json["textures"][0]["sampler"] = 0;
        const Scene scene = m.read();
        EXPECT_EQ(scene.textures.at(0).wrapU, u);
        EXPECT_EQ(scene.textures.at(0).wrapV, v);
        EXPECT_NE(scene.contentHash(), plain);
    }
}

TEST(Gltf, TextureCoordinatesAreTransformedAsTheSpecificationsExampleSays) {
    // KHR_texture_transform's example: the lower left quadrant of the picture, turned by a quarter.
    Json material = materialOf("MASK", -1, 1);
    material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {{"offset", {0, 1}}, {"rotation", std::numbers::pi / 2}, {"scale", {0.5, 0.5}}};
    Maker m = cardOf({0, 255}, material);
    const Scene scene = m.read();
    base::Box uvs;
    for (const glm::vec2& uv : scene.prototypes[0].meshes[0].uvs) uvs.extend(glm::vec3(uv, 0));
    EXPECT_NEAR(glm::distance(uvs.lo, glm::vec3(0, 0.5f, 0)), 0, 1e-6);
    EXPECT_NEAR(glm::distance(uvs.hi, glm::vec3(0.5f, 1, 0)), 0, 1e-6);
}

TEST(Gltf, RequiredExtensionsAreReadOrRefusedByName) {
    Maker m;
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    for (const char* name : {"KHR_texture_basisu", "VENDOR_secret", "MSFT_lod"}) {
        m.json["extensionsRequired"] = {name};
        base::expectHolds(m.error(), name);
    }
    m.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_mesh_quantization"};
    m.json["extensionsUsed"] = {"KHR_materials_unlit", "KHR_mesh_quantization", "VENDOR_secret"};
    const Scene scene = m.read();
    EXPECT_TRUE(noted(scene, "KHR_materials_unlit") && noted(scene, "VENDOR_secret"));
    EXPECT_FALSE(noted(scene, "KHR_mesh_quantization"));
}

TEST(Gltf, WhatIsNotReadIsNamed) {
    Maker m = cardOf({255}, materialOf("MASK", -1, 1));
    m.json["animations"] = {{{"channels", Json::array()}, {"samplers", Json::array()}, {"name", "walk"}}};
    m.json["scenes"].push_back({{"nodes", {0}}});
    m.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", m.square()}}}, {"mode", 1}});
    m.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 0;
    m.json["images"][0]["uri"] = "gone.ktx2";
    const Scene scene = m.read();
    for (const char* part : {"animations", "walk", "scenes beside", "points, lines", "colours of vertices", "gone.ktx2"}) EXPECT_TRUE(noted(scene, part)) << part;
    EXPECT_EQ(scene.materials.at(0).texture, -1);
}

TEST(Gltf, LampsAndFurtherSunsAreRead) {
    Maker m;
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    m.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}, {"intensity", 4}}, {{"type", "directional"}, {"intensity", 1}}, {{"type", "point"}, {"intensity", 9}, {"color", {1, 0.5, 0}}},
                                                             {{"type", "spot"}, {"intensity", 2}, {"range", 7}, {"spot", {{"outerConeAngle", 0.5}}}}};
    const double tilt = std::sin(-std::numbers::pi / 8), rest = std::cos(std::numbers::pi / 8);  // 45° down
    for (const int light : {0, 1, 2, 3}) {
        m.json["nodes"].push_back({{"name", "one name"}, {"translation", {1, 2, 3}}, {"rotation", {tilt, 0, 0, rest}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
        m.json["scenes"][0]["nodes"].push_back(light + 1);
    }
    const Scene scene = m.read();
    EXPECT_EQ(scene.sun.elevation, 45);
    EXPECT_EQ(scene.sun.azimuth, 180);
    ASSERT_EQ(scene.furtherSuns.size(), 1u);
    EXPECT_EQ(scene.furtherSuns[0].strength, 0.25);
    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_EQ(scene.lights[0].position, glm::vec3(1, -3, 2));
    EXPECT_EQ(scene.lights[0].intensity, glm::vec3(9, 4.5f, 0));
    EXPECT_FLOAT_EQ(scene.lights[0].range, 30);  // 9 / 30² is a hundredth
    EXPECT_FLOAT_EQ(scene.lights[1].outerAngle, 0.5f);
    EXPECT_FLOAT_EQ(scene.lights[1].range, 7);
    EXPECT_NEAR(scene.lights[1].direction.z, -std::numbers::sqrt2 / 2, 1e-6);
}

TEST(Gltf, BarkAndLeavesInTheSamePlacesAreOneTree) {
    Maker m;
    const size_t places = m.accessor<float>({0, 0, 0, 5, 0, 0, 9, 0, 1}, "VEC3", 3);
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    m.mesh({{"attributes", {{"POSITION", m.accessor<float>({0, 0, 1, 1, 0, 1, 0, 2, 1}, "VEC3", 3)}}}});
    m.json["nodes"] = Json::array();
    for (const int mesh : {0, 1}) m.json["nodes"].push_back({{"mesh", mesh}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
    m.json["scenes"][0]["nodes"] = {0, 1};
    const Scene scene = m.read();
    EXPECT_EQ(scene.prototypes.size(), 1u);
    EXPECT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(scene.facts().triangles, 9u);
}

TEST(Gltf, TheSameSceneThroughOtherToolsIsTheSame) {
    const Scene right = importFile(gltfFixtures() / "tools/00-export.glb");
    EXPECT_EQ(right.facts().triangles, 7232u);
    for (const char* name : {"03-meshopt.glb", "04-draco.glb", "05-webp.glb", "11-separate.gltf", "21-pack-cc.glb", "22-pack-mi.glb", "23-pack-noq.glb", "31-pipeline-draco.glb"}) {
        SCOPED_TRACE(name);
        const Scene scene = importFile(gltfFixtures() / "tools" / name);
        // Quantization flattens some of gltfpack's triangles; they are counted.
        EXPECT_EQ(scene.facts().triangles + (std::string(name) == "21-pack-cc.glb" ? 8 : 0), 7232u);
        EXPECT_EQ(scene.instances.size(), 10u);
        EXPECT_TRUE(scene.facts().alphaTested);
        const View& view = scene.views.at(scene.viewIndex("eye"));
        EXPECT_EQ(view.far, 90);
        EXPECT_EQ(view.near, 0.3);
        EXPECT_EQ(view.fovY, 60);
        EXPECT_EQ(scene.sun.azimuth, right.sun.azimuth);
        EXPECT_EQ(scene.sun.elevation, right.sun.elevation);
        EXPECT_NEAR(areaOf(scene) / areaOf(right), 1, 2e-3);
    }
}

// The bound is that of a loaded machine; what is not linear in the nodes misses it by far.
TEST(Gltf, AHundredThousandNodesOfOursAreReadInSeconds) {
    Scene scene = loadScene("box");
    scene.instances.resize(1);
    for (int i = 0; i < 100'000; ++i) {
        scene.instances.push_back(scene.instances[0]);
        scene.instances.back().translation = {float(i % 317) * 3, float(i / 317) * 3, 0};
    }
    scene.motions.clear();
    const fs::path file = fs::temp_directory_path() / fmt::format("dapple_many_{}.glb", ::getpid());
    writeGlb(scene, file);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(importFile(file).contentHash(), scene.contentHash());
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 8);
    fs::remove(file);
}

}  // namespace
}  // namespace dapple::scenegen
