#include "base/expect_error.h"
#include "base/file.h"
#include "scenegen/export/glb.h"
#include "scenegen/export/obj.h"
#include "scenegen/import/import.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <filesystem>

using namespace dapple::scenegen;

namespace {

std::filesystem::path written(const Scene& scene) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / (scene.name + ".glb");
    writeGlb(scene, path);
    return path;
}

nlohmann::json jsonOf(const std::filesystem::path& path) {
    const std::string file = dapple::base::readFile(path);
    uint32_t header[5];
    std::memcpy(header, file.data(), sizeof header);
    EXPECT_EQ(header[0], 0x46546C67u);
    EXPECT_EQ(header[1], 2u);
    EXPECT_EQ(header[2], file.size());
    return nlohmann::json::parse(file.substr(20, header[3]));
}

}  // namespace

// Over all named scenes, with lamps, traffic and wind.
TEST(Export, readingBackGivesTheSameSceneToTheBit) {
    for (const SceneEntry& entry : listScenes()) {
        SCOPED_TRACE(entry.name);
        std::vector<std::string> settings{"scale=0.01"};
        if (entry.name == "arboretum") settings.push_back("wind.strength=0.5");
        Scene scene = loadScene(entry.name, settings);
        scene.lights = {{{1, 2, 3}, {0, 0, -1}, {3, 2, 0.1f}, 17, 0.2f, 1.1f}, {}};
        if (!scene.instances.empty()) scene.motions = {{0, {0.1f, 0, 0}, {1, 5, 0}, 3.3f, 0.7f, 3.1f, 2.7f}};
        const std::filesystem::path path = written(scene);
        const Scene back = loadScene(path.string());
        EXPECT_EQ(back.contentHash(), scene.contentHash());
        EXPECT_EQ(back.name, scene.name);
        const Facts a = scene.facts(), b = back.facts();
        EXPECT_EQ(std::tie(a.moving, a.closed, a.casters, a.lights), std::tie(b.moving, b.closed, b.casters, b.lights));
        std::filesystem::remove(path);
    }
}

TEST(Export, aDamagedFileOfOursIsOneErrorThatNamesIt) {
    const std::filesystem::path path = written(loadScene("box"));
    const std::string whole = dapple::base::readFile(path);
    for (const size_t keep : {whole.size() - 7, whole.size() / 2 + whole.size() / 3}) {
        dapple::base::writeFile(path, whole.substr(0, keep));
        dapple::base::expectHolds(dapple::base::errorLine([&] { importFile(path); }), path.filename().string());
    }
    std::string wrong = whole;
    wrong.replace(wrong.find("\"POSITION\":0"), 12, "\"POSITION\":9");
    dapple::base::writeFile(path, wrong);
    const std::string line = dapple::base::errorLine([&] { importFile(path); });
    dapple::base::expectHolds(line, path.filename().string());
    dapple::base::expectHolds(line, "damaged");
}

/// The file as another program would have written it.
std::filesystem::path disowned(const Scene& scene) {
    const std::filesystem::path path = written(scene);
    std::string file = dapple::base::readFile(path);
    file.replace(file.find(kGlbGenerator), 6, "foreig");
    for (size_t at = 0; (at = file.find("\"extras\"", at)) != std::string::npos;) file.replace(at, 8, "\"unread\"");
    dapple::base::writeFile(path, file);
    return path;
}

TEST(Export, otherReadersSeeTheSameForest) {
    const Scene scene = loadScene("forest-small"), back = importFile(disowned(scene));
    const Facts a = scene.facts(), b = back.facts();
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.uniqueTriangles, b.uniqueTriangles) << "instances share their meshes";
    EXPECT_TRUE(b.alphaTested);
    const glm::dvec3 lo = glm::dvec3(b.box.lo) + back.origin - scene.origin, hi = glm::dvec3(b.box.hi) + back.origin - scene.origin;
    // The box of a turned tree is that of its box's corners, so both sides overestimate alike.
    EXPECT_LT(glm::distance(lo, glm::dvec3(a.box.lo)), 2e-3);
    EXPECT_LT(glm::distance(hi, glm::dvec3(a.box.hi)), 2e-3);
}

TEST(Export, whatTheFormatHasAWordForOutlivesOtherPrograms) {
    Scene scene = loadScene("forest-small");
    scene.textures.at(0).wrapU = Wrap::mirror;
    scene.textures[0].wrapV = Wrap::clamp;
    for (Material& m : scene.materials) {
        if (m.texture >= 0) m.alphaCutoff = 0.3f;
        m.specular = 0.25f;
        m.shininess = 40;
    }
    EXPECT_EQ(importFile(written(scene)).contentHash(), scene.contentHash());
    const Scene back = importFile(disowned(scene));
    EXPECT_EQ(back.textures.at(0).wrapU, Wrap::mirror);
    EXPECT_EQ(back.textures[0].wrapV, Wrap::clamp);
    for (const Material& m : back.materials) {
        EXPECT_NEAR(m.specular, 0.25, 1e-6);
        EXPECT_NEAR(m.shininess, 40, 1e-4);
        if (m.texture >= 0) {
            EXPECT_NEAR(m.alphaCutoff, 0.3, 1e-6);
        }
    }
    for (const View& view : scene.views) EXPECT_FLOAT_EQ(float(back.views[back.viewIndex(view.name)].far), float(view.far));
}

// Oracle: Assimp's reader, and the scene's own triangles under their instances.
TEST(Export, anObjHoldsTheSameTriangles) {
    const Scene scene = loadScene("forest-small");
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "forest.obj";
    writeObj(scene, path);
    const Scene back = importFile(path);
    const Facts a = scene.facts(), b = back.facts();
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_TRUE(b.alphaTested);
    const auto area = [](const Scene& s) {
        double sum = 0;
        for (const Instance& i : s.instances)
            for (const Mesh& m : s.prototypes[i.prototype].meshes)
                for (size_t t = 0; t < m.indices.size(); t += 3) {
                    const glm::dvec3 p = m.positions[m.indices[t]], q = m.positions[m.indices[t + 1]], r = m.positions[m.indices[t + 2]];
                    sum += glm::length(glm::cross(q - p, r - p)) / 2 * double(i.scale) * double(i.scale);
                }
        return sum;
    };
    EXPECT_NEAR(area(back) / area(scene), 1, 1e-4);
    // Exact boxes of turned prototypes: those of the written vertices.
    dapple::base::DBox box;
    for (const Instance& i : scene.instances)
        for (const Mesh& m : scene.prototypes[i.prototype].meshes)
            for (const glm::vec3& p : m.positions) {
                const double c = std::cos(double(i.yaw)), s = std::sin(double(i.yaw));
                box.extend(glm::dvec3(i.translation) + double(i.scale) * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z));
            }
    EXPECT_LT(glm::distance(glm::dvec3(b.box.lo) + back.origin, box.lo), 2e-3);
    EXPECT_LT(glm::distance(glm::dvec3(b.box.hi) + back.origin, box.hi), 2e-3);
    for (const Material& m : back.materials) EXPECT_TRUE(!m.alphaTested || m.texture >= 0);
}

TEST(Export, otherReadersSeeTheViews) {
    const Scene scene = loadScene("box"), back = importFile(disowned(scene));
    ASSERT_EQ(back.views.size(), scene.views.size());
    for (const View& view : scene.views) {
        const View& copy = back.views[back.viewIndex(view.name)];
        EXPECT_LT(glm::distance(copy.eye + back.origin, view.eye + scene.origin), 1e-4);
        EXPECT_LT(glm::distance(copy.forward, view.forward), 1e-4);
        EXPECT_NEAR(copy.fovY, view.fovY, 0.01);
    }
}

TEST(Export, theFileIsWhatTheSpecificationAsks) {
    const Scene scene = loadScene("forest-small");
    const nlohmann::json j = jsonOf(written(scene));
    EXPECT_EQ(j["asset"]["version"], "2.0");
    EXPECT_EQ(j["meshes"].size(), scene.prototypes.size());
    size_t users = 0;
    for (const auto& node : j["nodes"]) users += node.contains("mesh");
    EXPECT_EQ(users, scene.instances.size());
    bool masked = false;
    for (const auto& material : j["materials"]) masked |= material.value("alphaMode", "OPAQUE") == "MASK";
    EXPECT_TRUE(masked);
    EXPECT_EQ(j["images"].size(), scene.textures.size());
    EXPECT_EQ(j["cameras"].size(), scene.views.size());
    for (const auto& view : j["bufferViews"]) {
        EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
        EXPECT_LE(view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>(), j["buffers"][0]["byteLength"].get<size_t>());
    }
}

TEST(Export, aSceneWithoutGeometryIsStillAFile) {
    const nlohmann::json j = jsonOf(written(loadScene("nothing")));
    EXPECT_FALSE(j.contains("meshes"));
    EXPECT_FALSE(j.contains("buffers"));
    EXPECT_EQ(j["cameras"].size(), 1u);
}

TEST(Export, anUnwritablePlaceIsOneError) {
    EXPECT_THROW(writeGlb(loadScene("nothing"), "/proc/nowhere/x.glb"), dapple::base::UsageError);
}
