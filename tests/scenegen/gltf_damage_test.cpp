#include "scenegen/gltf_maker.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dapple::scenegen {
namespace {

TEST(GltfDamage, UrisAreDecodedAndStayInTheFolder) {
    EXPECT_EQ(importFile(gltfFixtures() / "uri/buffer.gltf").facts().triangles, 14u);
    for (const char* name : {"space", "umlaut", "control"}) EXPECT_TRUE(importFile(gltfFixtures() / "uri" / (std::string(name) + ".gltf")).facts().alphaTested) << name;
    Maker m;
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    const fs::path file = m.write();
    for (const char* uri : {"../t.bin", "/etc/passwd", "%2e%2e/t.bin", "sub/../../t.bin"}) {
        Json json = m.json;
        json["buffers"][0]["uri"] = uri;
        base::writeFile(file, json.dump());
        base::expectHolds(base::errorLine([&] { importFile(file); }), "outside its folder");
    }
    fs::create_symlink("/etc/passwd", m.folder() / "link.bin");
    m.json["buffers"][0]["uri"] = "link.bin";
    base::writeFile(file, m.json.dump());
    base::expectHolds(base::errorLine([&] { importFile(file); }), "outside its folder");
}

TEST(GltfDamage, NodesNestAsDeepAsTheyLikeButNotInCircles) {
    base::expectHolds(base::errorLine([] { importFile(gltfFixtures() / "nodes/cycle.gltf"); }), "own ancestor");
    Maker m;
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    m.json["nodes"] = Json::array();
    for (int i = 0; i < 12000; ++i) m.json["nodes"].push_back({{"children", {i + 1}}, {"translation", {0.25, 0, 0}}});
    m.json["nodes"].push_back({{"mesh", 0}});
    EXPECT_NEAR(boxOf(m.read()).lo.x, 3000, 1e-6);
    m.json["nodes"].back()["children"] = {12000};
    base::expectHolds(m.error(), "own ancestor");
}

TEST(GltfDamage, SmallFilesCannotAskForMuch) {
    const auto start = std::chrono::steady_clock::now();
    Maker shared;  // 2^30 paths through 31 nodes
    shared.mesh({{"attributes", {{"POSITION", shared.square()}}}, {"mode", 5}});
    shared.json["nodes"] = Json::array();
    for (int i = 0; i < 30; ++i) shared.json["nodes"].push_back({{"children", {i + 1, i + 1}}});
    shared.json["nodes"].push_back({{"mesh", 0}});
    base::expectHolds(shared.error(), "more than a scene file may");

    Maker many;  // no bytes stand behind them
    many.mesh({{"attributes", {{"POSITION", many.square()}}}, {"mode", 5}});
    many.json["accessors"][0] = {{"componentType", 5126}, {"count", 400'000'000}, {"type", "VEC3"}};
    base::expectHolds(many.error(), "bytes");
    many.json["accessors"][0] = {{"componentType", 5126}, {"count", 400'000'000}, {"type", "VEC3"}, {"bufferView", 0}};
    base::expectHolds(many.error(), "ends beyond");
    many.json["accessors"][0]["count"] = 1e300;
    base::expectHolds(many.error(), "whole number");

    Maker packed;
    packed.mesh({{"attributes", {{"POSITION", packed.square()}}}, {"mode", 5}});
    packed.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0}, {"byteLength", 40}, {"byteStride", 256}, {"count", 4'000'000'000u}, {"mode", "ATTRIBUTES"}};
    base::expectHolds(packed.error(), "bytes");
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 10);
}

TEST(GltfDamage, DamagedFilesAreOneLine) {
    Maker m;
    m.mesh({{"attributes", {{"POSITION", m.square()}}}, {"mode", 5}});
    m.write();
    const Json whole = m.json;
    const auto line = [&](const char* pointer, const Json& value) {
        m.json = whole;
        m.json[Json::json_pointer(pointer)] = value;
        return m.error();
    };
    base::expectHolds(line("/asset", Json::array()), "asset.version");
    base::expectHolds(line("/asset/version", "1.0"), "glTF 1.0");
    base::expectHolds(line("/nodes", nullptr), "nodes");
    base::expectHolds(line("/nodes/0", nullptr), "not an object");
    base::expectHolds(line("/nodes/0/children", Json::array({nullptr})), "children");
    base::expectHolds(line("/nodes/0/mesh", -1), "mesh");
    base::expectHolds(line("/nodes/0/mesh", 7), "meshes[7]");
    base::expectHolds(line("/nodes/0/translation", Json::array({1, 2})), "damaged");
    base::expectHolds(line("/nodes/0/translation", Json::array({1e39, 2, 3})), "finite");
    base::expectHolds(line("/meshes/0/primitives/0/attributes/POSITION", 9), "accessors[9]");
    base::expectHolds(line("/meshes/0/primitives/0/mode", 9), "mode");
    base::expectHolds(line("/accessors/0/type", "VEC7"), "VEC7");
    base::expectHolds(line("/accessors/0/componentType", 1), "component type");
    base::expectHolds(line("/bufferViews/0/byteLength", 9999), "ends beyond");
    base::expectHolds(line("/scene", 4), "scenes[4]");
    base::expectHolds(line("/nodes/0/name", 4), "damaged");

    const auto text = [&](std::string_view s) {
        const fs::path file = m.write("x.gltf", s);
        return base::errorLine([&] { importFile(file); });
    };
    const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
    base::expectHolds(text(deep), "nested deeper");
    base::expectHolds(text("{\"asset\":{\"version\":\"2.0\",\"extras\":" + deep + "}}"), "nested deeper");
    Json without = whole;
    without["buffers"][0].erase("uri");
    base::expectHolds(text(without.dump()), "neither a uri nor data");
    without["buffers"][0] = {{"uri", "gone.bin"}, {"byteLength", 48}};
    base::expectHolds(text(without.dump()), "gone.bin");
    without["buffers"][0] = {{"uri", "data:application/octet-stream;base64,AAAA"}, {"byteLength", 48}};
    base::expectHolds(text(without.dump()), "3 bytes");
    base::expectHolds(text("[]"), "asset.version");
    base::expectHolds(text("{}"), "asset.version");
    base::expectHolds(text("{\"asset\":"), "cannot be read");
}

}  // namespace
}  // namespace dapple::scenegen
