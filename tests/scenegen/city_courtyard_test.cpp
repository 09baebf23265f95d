#include "base/detmath.h"
#include "base/hash.h"
#include "scenegen/city/arcade.h"
#include "scenegen/city/curved.h"
#include "scenegen/library.h"
#include "scenegen/lod/connectivity.h"
#include "recipe_error.h"
#include "winding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

using namespace dapple::scenegen;
using namespace dapple::scenegen::city;

namespace {

double volume(const Mesh& mesh) {
    double sum = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
        sum += glm::dot(glm::dvec3(mesh.positions[mesh.indices[i]]), glm::cross(glm::dvec3(mesh.positions[mesh.indices[i + 1]]), glm::dvec3(mesh.positions[mesh.indices[i + 2]]))) / 6;
    return sum;
}

void expectSound(const Mesh& mesh, const char* what) {
    const Connectivity c = connectivity(mesh);
    EXPECT_TRUE(c.closed()) << what << ": " << c.boundary << " open, " << c.nonManifold << " non-manifold, " << c.degenerate << " degenerate";
    EXPECT_GT(volume(mesh), 0) << what << " faces outwards";
    for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-5) << what;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]], d = mesh.positions[mesh.indices[i + 2]];
        for (size_t k = 0; k < 3; ++k) ASSERT_GT(glm::dot(glm::normalize(glm::cross(b - a, d - a)), glm::dvec3(mesh.normals[mesh.indices[i + k]])), 0.5) << what << ": normals lean with the surface";
    }
}


}  // namespace

TEST(Curved, lathesHoldTheVolumeOfTheirCones) {
    Mesh m;
    const glm::dvec2 profile[] = {{1.0, 0.5}, {1.5, 1.0}, {1.5, 2.0}, {0.5, 2.5}};
    addLathe(m, {0, 0, -0.5}, profile, 96);
    expectSound(m, "lathe");
    // A regular 96-gon has 96 / 2 · sin(2π / 96) of its circle's r².
    const double disc = 48 * std::sin(2 * M_PI / 96), cone = 0.5 / 3 * (1 + 1.5 + 2.25) + 2.25 + 0.5 / 3 * (2.25 + 0.75 + 0.25);
    EXPECT_NEAR(volume(m), disc * cone, 1e-4);
    EXPECT_EQ(connectivity(m).components, 1u);
    for (const glm::vec3& p : m.positions) EXPECT_LE(glm::length(glm::vec2(p)), 1.5f + 1e-6f);
}

TEST(Curved, archesLeaveHalfADiscOpen) {
    Mesh panel, ring;
    addArchPanel(panel, {4, 1.6, 3, 5, 0.5}, 64);
    addArchRing(ring, 3, 1.6, 1.9, -0.3, 0.3, 64);
    expectSound(panel, "panel");
    expectSound(ring, "ring");
    const double halfDisc = 32 * std::sin(M_PI / 64);
    EXPECT_NEAR(volume(panel), 0.5 * (4 * 2 - halfDisc * 1.6 * 1.6), 1e-5);
    EXPECT_NEAR(volume(ring), 0.6 * halfDisc * (1.9 * 1.9 - 1.6 * 1.6), 1e-5);
    for (double x = -1.93; x < 2; x += 0.31)
        for (double z = 3.07; z < 5; z += 0.29) {
            const double r = std::hypot(x, z - 3);
            if (std::abs(r - 1.6) < 0.02 || std::abs(r - 1.9) < 0.02) continue;
            EXPECT_EQ(windingNumber(panel, {x, 0.1, z}), int(r > 1.6)) << x << " " << z;
            EXPECT_EQ(windingNumber(ring, {x, 0.1, z}), int(r > 1.6 && r < 1.9)) << x << " " << z;
        }
}

TEST(Curved, sheetsAreThinSolids) {
    Mesh m;
    addSheet(m, 40, 30, 0.02, [](double u, double v) {
        return glm::dvec3(2 * u, 0.2 * std::sin(12 * u), 3 * v);
    });
    expectSound(m, "sheet");
    EXPECT_TRUE(connectivity(m).spheres);
    // Length of the wave by fine steps, times height and thickness.
    double length = 0;
    for (int i = 0; i < 40; ++i) length += std::hypot(2.0 / 40, 0.2 * (std::sin(12 * (i + 1) / 40.0) - std::sin(12 * i / 40.0)));
    EXPECT_NEAR(volume(m), length * 3 * 0.02, 0.03 * length * 3 * 0.02);
}

TEST(Courtyard, everyPartIsClosedWithSmoothNormals) {
    expectSound(lowerColumn(), "column");
    expectSound(upperColumn(), "slender column");
    expectSound(lowerArch(), "arch");
    expectSound(transverseArch(), "transverse arch");
    expectSound(upperArches(), "pair of arches");
    expectSound(balustrade(), "balustrade");
    expectSound(roofTiles(), "tiles");
    expectSound(cornerTiles(false), "corner");
    expectSound(cornerTiles(true), "mirrored corner");
    expectSound(pot(), "pot");
    expectSound(planter(), "planter");
    expectSound(fountain().stone, "fountain");
    expectSound(fountain().water, "water");
    expectSound(banner(), "banner");
    expectSound(curtain(), "curtain");
}

TEST(Courtyard, isClosedAndOfTheSizeThatItStates) {
    const Facts f = loadScene("flythrough").facts();
    EXPECT_TRUE(f.closed);
    EXPECT_FALSE(f.alphaTested);
    EXPECT_FALSE(f.moving);
    EXPECT_GT(f.triangles, 200'000u);
    EXPECT_LT(f.triangles, 400'000u);
    EXPECT_LT(f.uniqueTriangles, f.triangles / 4) << "columns, arches and tiles are instances";
}

TEST(Courtyard, costGrowsWithTheScaleFromATestSizeTo16) {
    size_t last = 0;
    for (const char* scale : {"0.1", "1", "4", "16"}) {
        const Facts f = loadScene("flythrough", {std::string("scale=") + scale}).facts();
        EXPECT_GT(f.triangles, 2 * last);
        last = f.triangles;
    }
    const double one = double(loadScene("flythrough", {"scale=1"}).facts().triangles);
    // The two ends of the court do not grow.
    EXPECT_GT(double(last), 9 * one);
    EXPECT_LT(double(last), 16 * one);
}

TEST(Courtyard, theFlightMeetsNothing) {
    for (const char* scale : {"0.1", "1", "3"}) {
        const Scene scene = loadScene("flythrough", {std::string("scale=") + scale});
        ASSERT_EQ(scene.views.size(), 7u);
        for (const View& view : scene.views) {
            EXPECT_DOUBLE_EQ(view.near, 0.1);
            EXPECT_LT(glm::distance(glm::dvec3(scene.facts().box.centre()), view.eye), view.far);
            for (const Instance& i : scene.instances) {
                const Prototype& p = scene.prototypes[i.prototype];
                const dapple::base::Box box = instanceBox(p.box(), i);
                if (glm::distance(glm::clamp(view.eye, glm::dvec3(box.lo), glm::dvec3(box.hi)), view.eye) > 0.5) continue;
                const double c = std::cos(double(i.yaw)), s = std::sin(double(i.yaw));
                const glm::dvec3 d = (view.eye - glm::dvec3(i.translation)) / double(i.scale), local(c * d.x + s * d.y, c * d.y - s * d.x, d.z);
                for (const Mesh& m : p.meshes) {
                    EXPECT_EQ(windingNumber(m, local), 0) << view.name << " within " << p.name;
                    for (const glm::vec3& v : m.positions) ASSERT_GT(glm::distance(glm::dvec3(v), local) * double(i.scale), 0.3) << view.name << " at " << p.name << ", scale " << scale;
                }
            }
        }
    }
}

TEST(Courtyard, plantsStandInTheirPotsAndKeepClearOfTheArcade) {
    const Scene scene = loadScene("flythrough");
    size_t plants = 0;
    for (const Instance& i : scene.instances) {
        const std::string& name = scene.prototypes[i.prototype].name;
        if (!name.starts_with("oak") && !name.starts_with("shrub") && !name.starts_with("fern")) continue;
        ++plants;
        bool potted = false;
        for (const Instance& pot : scene.instances) {
            const std::string& what = scene.prototypes[pot.prototype].name;
            potted = potted || ((what == "pot" || what == "planter") && glm::distance(glm::vec2(pot.translation), glm::vec2(i.translation)) < 1e-4f);
        }
        EXPECT_TRUE(potted) << name;
        const dapple::base::Box box = instanceBox(scene.prototypes[i.prototype].box(), i);
        EXPECT_LT(box.hi.z, 6);
        for (int axis = 0; axis < 2; ++axis) EXPECT_LT(std::max(-box.lo[axis], box.hi[axis]), axis == 0 ? 18.5f : 8.5f) << name;
    }
    EXPECT_GT(plants, 20u);
    EXPECT_EQ(loadScene("flythrough", {"courtyard.plants=0"}).facts().triangles > 150'000u, true);
}

/// Taken from g++ 12 at -O2 and clang++ 14 at -O0, which agree.
TEST(Courtyard, givesTheSameBytesEverywhere) { EXPECT_EQ(dapple::base::hex16(loadScene("flythrough").contentHash()), "5c9c1e6aac00d983"); }

TEST(Courtyard, badValuesNameFileLineAndKey) {
    EXPECT_THAT(recipeError("[courtyard]\nbays = 1\n"), testing::HasSubstr(".toml:3: bays: 1 is outside"));
    EXPECT_THAT(recipeError("[courtyard]\nbay = 3\n"), testing::HasSubstr("did you mean 'bays'?"));
    EXPECT_THAT(recipeError("scale = 100\n[courtyard]\n"), testing::HasSubstr("at a scale from 0.01 to 64, not 100"));
}
