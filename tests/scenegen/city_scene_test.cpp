#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "scenegen/library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

using namespace dapple::scenegen;
using testing::HasSubstr;

namespace {

class EveryCity : public testing::TestWithParam<const char*> {
protected:
    Scene load(const std::string& scale, const std::string& seed = "3") const { return loadScene(GetParam(), {"scale=" + scale, "seed=" + seed}); }
};

std::string errorOf(const std::string& city) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "city_under_test.toml";
    dapple::base::writeFile(path, "description = \"x\"\n[city]\n" + city);
    try {
        loadScene(path.string());
    } catch (const dapple::base::UsageError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST_P(EveryCity, theTestSizeIsSmallAndWhole) {
    const Scene scene = load("0.015625");
    const Facts f = scene.facts();
    EXPECT_GT(f.triangles, 50'000u);
    EXPECT_LT(f.triangles, 4'000'000u);
    EXPECT_TRUE(f.rotated);
    EXPECT_FALSE(f.alphaTested);
    for (const Prototype& p : scene.prototypes) EXPECT_EQ(p.closed, !p.name.starts_with("street tree")) << p.name;
    std::set<uint32_t> used;
    for (const Instance& i : scene.instances) used.insert(i.prototype);
    for (uint32_t p = 0; p < scene.prototypes.size(); ++p) EXPECT_TRUE(used.contains(p) || scene.prototypes[p].triangles() < 600) << "only small furniture may lie idle";
    size_t walks = 0;
    for (const View& v : scene.views)
        if (v.name.starts_with("walk")) {
            ++walks;
            EXPECT_DOUBLE_EQ(v.eye.z, 1.7);
            EXPECT_DOUBLE_EQ(v.near, 0.3);
        }
    EXPECT_GE(walks, 4u);
    EXPECT_EQ(scene.views.back().name, "above");
}

TEST_P(EveryCity, walkersStandInTheOpen) {
    // Nothing but the ground within a metre of an eye, by the triangles of everything near.
    for (const char* seed : {"1", "2"}) {
        const Scene scene = load("0.03", seed);
        for (const View& view : scene.views)
            for (const Instance& i : scene.instances) {
                const Prototype& p = scene.prototypes[i.prototype];
                if (!p.castsShadow || p.name.starts_with("pavement")) continue;
                const dapple::base::Box box = instanceBox(p.box(), i);
                const glm::dvec3 nearest = glm::clamp(view.eye, glm::dvec3(box.lo), glm::dvec3(box.hi));
                if (glm::distance(nearest, view.eye) > 1) continue;
                const double c = std::cos(double(i.yaw)), s = std::sin(double(i.yaw));
                for (const Mesh& m : p.meshes)
                    for (const glm::vec3& v : m.positions) {
                        const glm::dvec3 w = glm::dvec3(i.translation) + double(i.scale) * glm::dvec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
                        ASSERT_GT(glm::distance(w, view.eye), 1) << view.name << " beside " << p.name;
                    }
            }
    }
}

TEST_P(EveryCity, areaAndCostGrowWithTheScale) {
    const Facts small = load("0.03").facts(), large = load("0.12").facts();
    const double ratio = double(large.triangles) / double(small.triangles);
    EXPECT_GT(ratio, 2.5);
    EXPECT_LT(ratio, 6.5);
    const auto area = [](const Facts& f) { return double(f.box.size().x - 200) * double(f.box.size().y - 200); };
    EXPECT_NEAR(area(large) / area(small), 4, 1.5);
}

TEST_P(EveryCity, seedsRepeatAndDiffer) {
    EXPECT_EQ(load("0.015625").contentHash(), load("0.015625").contentHash());
    EXPECT_NE(load("0.015625", "4").contentHash(), load("0.015625", "5").contentHash());
}

/// Taken from g++ 12 at -O2 and clang++ 14 at -O0, which agree.
TEST(City, recipesGiveTheSameBytesEverywhere) {
    for (const auto& [name, hash] : {std::pair("city-vienna", "e19fd736563cad65"), {"city-manhattan", "9d2d7f777e790cb0"}})
        EXPECT_EQ(dapple::base::hex16(loadScene(name, {"scale=0.1"}).contentHash()), hash) << name;
}

INSTANTIATE_TEST_SUITE_P(Styles, EveryCity, testing::Values("city-vienna", "city-manhattan"), [](const auto& test) { return std::string(test.param).substr(5); });

TEST(City, viennaHasTwelveMillionTriangles) { EXPECT_NEAR(double(loadScene("city-vienna").facts().triangles), 12e6, 1.2e6); }

TEST(City, manhattanHasAHundredMillionTrianglesInLittleMemory) {
    const Scene scene = loadScene("city-manhattan");
    const Facts f = scene.facts();
    EXPECT_NEAR(double(f.triangles), 100e6, 10e6);
    size_t bytes = scene.instances.size() * sizeof(Instance);
    for (const Prototype& p : scene.prototypes)
        for (const Mesh& m : p.meshes) bytes += m.positions.size() * 24 + m.indices.size() * 4;
    EXPECT_LT(double(bytes), 2.0 * (1u << 30));
    EXPECT_LT(double(bytes) / double(f.triangles), 16);
}

TEST(City, badValuesNameFileLineAndKey) {
    EXPECT_THAT(errorOf("style = \"paris\"\n"), HasSubstr("city_under_test.toml:3: style: 'paris' is none of vienna, manhattan"));
    EXPECT_THAT(errorOf("scale = 0\n"), HasSubstr("unknown key 'scale'"));  // it is the recipe's
    EXPECT_THROW(loadScene("city-vienna", {"scale=0.0001"}), dapple::base::UsageError);
    EXPECT_THAT(errorOf("views = 0\n"), HasSubstr(":3: views: 0 is outside"));
    EXPECT_THAT(errorOf("stile = \"vienna\"\n"), HasSubstr("did you mean 'style'?"));
}
