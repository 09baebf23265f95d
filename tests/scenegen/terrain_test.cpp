#include "scenegen/terrain/terrain.h"

#include "base/error.h"
#include "base/file.h"
#include "base/image.h"
#include "scenegen/lod/connectivity.h"
#include "scenegen/recipe.h"
#include "scenegen/terrain/height_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <set>

using namespace dapple;
using namespace dapple::scenegen;
namespace fs = std::filesystem;

namespace {

HeightField flat(int samples, double spacing, float z = 0) { return {samples, samples, spacing, std::vector<float>(size_t(samples) * size_t(samples), z)}; }

HeightField hills(int samples, uint64_t seed) {
    HeightField field = flat(samples, 2);
    addFbm(field, {.wavelength = 120, .octaves = 6, .seed = seed});
    field.stretch(40);
    return field;
}

double total(const HeightField& field) { return std::accumulate(field.heights.begin(), field.heights.end(), 0.0); }

}  // namespace

// Oracle: the triangles of the tile themselves.
TEST(HeightField, heightIsThatOfTheTrianglesThatAreDrawn) {
    const HeightField field = hills(33, 3);
    glm::dvec2 centre(0);
    const Mesh mesh = terrainTile(field, 0, 0, 32, 32, 1, 1, centre);
    for (size_t i = 0; i < 32 * 32 * 2; ++i) {
        glm::dvec3 sum(0);
        for (size_t k = 0; k < 3; ++k) sum += glm::dvec3(mesh.positions[mesh.indices[3 * i + k]]);
        sum /= 3;
        EXPECT_NEAR(field.height(sum.x + centre.x, sum.y + centre.y), sum.z, 1e-4);
    }
    EXPECT_EQ(field.height(-1e9, 0), field.height(field.x(0), 0));
}

TEST(HeightField, slopeIsRiseOverRun) {
    HeightField field = flat(17, 3);
    for (int j = 0; j < 17; ++j)
        for (int i = 0; i < 17; ++i) field.at(i, j) = float(0.3 * field.x(i) + 0.4 * field.y(j));
    EXPECT_NEAR(field.slope(1.3, -7.7), 0.5, 1e-6);
    EXPECT_LT(glm::distance(field.normal(5, 9), glm::normalize(glm::vec3(-0.3f, -0.4f, 1))), 1e-5f);
}

TEST(Fbm, isContinuousZeroOnItsLatticeAndNotPeriodic) {
    // One octave of gradient noise vanishes at its lattice points.
    HeightField field = flat(65, 1);
    addFbm(field, {.wavelength = 8, .octaves = 1, .seed = 5});
    for (int j = 0; j < 65; j += 8)
        for (int i = 0; i < 65; i += 8) EXPECT_EQ(field.at(i, j), 0.0f);
    double steepest = 0, apart = 0;
    for (int j = 0; j < 64; ++j)
        for (int i = 0; i < 64; ++i) {
            steepest = std::max(steepest, double(std::abs(field.at(i + 1, j) - field.at(i, j))));
            if (i + 8 < 65) apart += std::abs(field.at(i + 8, j) - field.at(i, j));
        }
    EXPECT_LT(steepest, 0.5);  // the gradient's bound is about 2.2 per lattice step
    EXPECT_GT(apart, 100);
    EXPECT_NE(hills(33, 1).heights, hills(33, 2).heights);
    EXPECT_EQ(hills(33, 1).heights, hills(33, 1).heights);
}

TEST(Erosion, leavesAPlainAloneAndNeitherMakesSoilNorPeaks) {
    HeightField plain = flat(64, 2, 7);
    erode(plain, 2000, 1);
    EXPECT_EQ(plain.heights, flat(64, 2, 7).heights);
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        const HeightField before = hills(129, seed);
        HeightField after = before;
        erode(after, 20'000, seed);
        for (const float z : after.heights) ASSERT_TRUE(std::isfinite(z));
        const double moved = total(before) - total(after);  // what drops still carry when they leave is lost
        EXPECT_GE(moved, -1e-6 * total(before));
        EXPECT_LT(moved, 0.2 * total(before));
        EXPECT_LE(*std::max_element(after.heights.begin(), after.heights.end()), 1.02f * *std::max_element(before.heights.begin(), before.heights.end()));
        EXPECT_NE(before.heights, after.heights);
    }
}

TEST(TerrainTile, isAClosedBodyAtEveryStepAndFacesUp) {
    const HeightField field = hills(65, 9);
    for (const int step : {1, 2, 4, 8}) {
        glm::dvec2 centre(0);
        const Mesh mesh = terrainTile(field, 16, 0, 48, 64, step, 1.5, centre);
        const Connectivity c = connectivity(mesh);
        EXPECT_TRUE(c.closed()) << step;
        EXPECT_TRUE(c.spheres) << step;
        const size_t n = size_t(32 / step), m = size_t(64 / step);
        EXPECT_EQ(c.triangles, 2 * n * m + 2 * (n + m) * 3);
        double area = 0, volume = 0;
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const glm::dvec3 p = mesh.positions[mesh.indices[i]], q = mesh.positions[mesh.indices[i + 1]], r = mesh.positions[mesh.indices[i + 2]];
            const glm::dvec3 cross = glm::cross(q - p, r - p);
            if (i < 2 * n * m * 3) {
                EXPECT_GT(cross.z, 0);
                area += cross.z / 2;
            }
            volume += glm::dot(p, glm::cross(q, r)) / 6;
        }
        EXPECT_NEAR(area, 64.0 * 128.0, 1e-2);
        EXPECT_GT(volume, 1.5 * 64 * 128);  // outward: the body lies inside, at least a skirt deep
        for (const glm::vec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-5);
    }
}

class HeightFile : public ::testing::Test {
protected:
    fs::path folder_ = fs::temp_directory_path() / ("dapple-terrain-" + std::to_string(getpid()));
    HeightFile() { fs::create_directories(folder_); }
    ~HeightFile() override { fs::remove_all(folder_); }

    fs::path write(const std::string& name, const std::string& bytes) {
        base::writeFile(folder_ / name, bytes);
        return folder_ / name;
    }
    Notes notes_;

    template <class T>
    static std::string little(T value) { return std::string(reinterpret_cast<const char*>(&value), sizeof(T)); }

    /// A .npy of 2 rows × 3 columns of T: 0 1 2 / 10 11 12, from the north.
    template <class T>
    static std::string npy(const std::string& type, const std::string& shape = "(2, 3)") {
        std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }\n";
        std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + little(uint16_t(header.size())) + header;
        for (const int v : {0, 1, 2, 10, 11, 12}) bytes += little(T(v));
        return bytes;
    }
    static std::string zipped(const std::string& entry) {  // stored
        return "PK\x03\x04" + std::string(4, '\0') + little(uint16_t(0)) + std::string(8, '\0') + little(uint32_t(entry.size())) +
               little(uint32_t(entry.size())) + little(uint16_t(5)) + little(uint16_t(0)) + "a.npy" + entry;
    }
};

TEST_F(HeightFile, numpyArraysOfEveryTypeHaveNorthOnTop) {
    for (const auto& [type, bytes] : {std::pair{"<i2", npy<int16_t>("<i2")}, {"<u2", npy<uint16_t>("<u2")}, {"<i4", npy<int32_t>("<i4")},
                                      {"<f4", npy<float>("<f4")}, {"<f8", npy<double>("<f8")}, {"|u1", npy<uint8_t>("|u1")}}) {
        const HeightField field = readHeights(write("h.npz", zipped(bytes)), 30, 2, notes_);
        ASSERT_EQ(field.columns, 3) << type;
        ASSERT_EQ(field.rows, 2);
        EXPECT_EQ(field.at(0, 0), 20);  // south-west
        EXPECT_EQ(field.at(2, 1), 4);   // north-east
        EXPECT_EQ(field.spacing, 30);
    }
}

// Oracle: numpy's reading of the same file, which is deflated.
TEST_F(HeightFile, aRealDeflatedArchiveIsRead) {
    const fs::path file = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz";
    if (!fs::exists(file)) GTEST_SKIP() << "python-matplotlib-data is not installed";
    const HeightField field = readHeights(file, 92.5, 1, notes_);
    ASSERT_EQ(field.columns, 403);
    ASSERT_EQ(field.rows, 344);
    EXPECT_EQ(field.at(0, 343), 483);
    EXPECT_EQ(field.at(1, 343), 487);
    EXPECT_EQ(field.at(2, 343), 491);
}

TEST_F(HeightFile, exrIsReadAsMetres) {
    base::writeExr(folder_ / "h.exr", {2, 2, 1, {1.5f, 2.5f, 3.5f, 4.5f}});
    const HeightField field = readHeights(folder_ / "h.exr", 1, 10, notes_);
    EXPECT_EQ(field.at(0, 0), 35);
    EXPECT_EQ(field.at(1, 1), 25);
}

TEST_F(HeightFile, pngOfEightBitsCounts257Each) {
    base::Image8 image{2, 2, 1, {0, 1, 2, 255}};
    base::writePng(folder_ / "h.png", image);
    const HeightField field = readHeights(folder_ / "h.png", 1, 1, notes_);
    EXPECT_EQ(field.at(1, 0), 65535);
    EXPECT_EQ(field.at(1, 1), 257);
}

TEST_F(HeightFile, marksForWhatWasNotMeasuredAreFilledAndCounted) {
    // A slanted plane, 64 × 48, with a round hole and a strip along the border: the membrane over them is the plane.
    const auto plane = [](int x, int y) { return float(300 + 2.5 * x - 1.5 * y); };
    const auto isHole = [](int x, int y) { return (x - 30) * (x - 30) + (y - 20) * (y - 20) < 100 || (x > 60 && y > 20); };
    const auto archive = [&](double mark) {
        std::string bytes = npy<float>("<f4", "(48, 64)");
        bytes.resize(bytes.size() - 6 * sizeof(float));
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) bytes += little(isHole(x, y) ? float(mark) : plane(x, y));
        return zipped(bytes);
    };
    for (const double mark : {-9999.0, -32768.0, 3.4e38, -3.4e38, double(NAN), double(INFINITY), -99999.0}) {
        SCOPED_TRACE(mark);
        notes_ = {};
        const HeightField field = readHeights(write("holes.npz", archive(mark)), 1, 1, notes_);
        size_t holes = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) {
                holes += isHole(x, y);
                // The border has no slope, so the strip there may differ by what the plane rises across it.
                ASSERT_NEAR(field.at(x, 47 - y), plane(x, y), isHole(x, y) ? (x > 60 ? 10 : 1) : 0) << x << ", " << y;
            }
        ASSERT_EQ(notes_.entries().size(), 1u);
        EXPECT_EQ(notes_.entries()[0].count, holes);
    }
    // Depths of the sea about -9,999 m are heights: others lie next to them.
    std::string sea = npy<int16_t>("<i2");
    sea.resize(sea.size() - 6 * sizeof(int16_t));
    for (const int z : {-9990, -9998, -9999, -10001, -10010, -10030}) sea += little(int16_t(z));
    notes_ = {};
    EXPECT_EQ(readHeights(write("sea.npz", zipped(sea)), 1, 1, notes_).at(2, 1), -9999);
    EXPECT_TRUE(notes_.entries().empty());
    std::string nothing = npy<int16_t>("<i2");
    nothing.resize(nothing.size() - 6 * sizeof(int16_t));
    for (int i = 0; i < 6; ++i) nothing += little(int16_t(-32768));
    EXPECT_THROW(readHeights(write("nothing.npz", zipped(nothing)), 1, 1, notes_), base::UsageError);
}

TEST_F(HeightFile, coloursAreRefusedAndTransparentSamplesAreHoles) {
    base::writePng(folder_ / "rgb.png", {2, 2, 3, {1, 134, 160, 1, 134, 161, 1, 134, 162, 1, 134, 163}});
    base::writePng(folder_ / "grey3.png", {2, 2, 3, {1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}});
    base::writePng(folder_ / "UP.PNG", {2, 2, 1, {1, 2, 3, 4}});
    base::writePng(folder_ / "alpha.png", {2, 2, 2, {5, 255, 5, 255, 200, 0, 5, 255}});
    base::writeExr(folder_ / "rgb.exr", {2, 2, 3, {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3}});
    base::writeExr(folder_ / "rg.exr", {2, 2, 2, {1, 2, 1, 2, 1, 2, 1, 2}});
    for (const char* name : {"rgb.png", "rgb.exr", "rg.exr"})
        EXPECT_THROW(readHeights(folder_ / name, 1, 1, notes_), base::UsageError) << name;
    EXPECT_EQ(readHeights(folder_ / "grey3.png", 1, 1, notes_).at(1, 0), 4 * 257);
    EXPECT_EQ(readHeights(folder_ / "UP.PNG", 1, 1, notes_).at(1, 0), 4 * 257);
    EXPECT_TRUE(notes_.entries().empty());
    EXPECT_EQ(readHeights(folder_ / "alpha.png", 1, 1, notes_).at(0, 0), 5 * 257);
    EXPECT_EQ(notes_.entries().size(), 1u);
}

TEST_F(HeightFile, pipesAreRefused) {
    for (const char* name : {"pipe.png", "pipe.exr", "pipe.npz"}) {
        ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
        EXPECT_THROW(readHeights(folder_ / name, 1, 1, notes_), base::UsageError) << name;
    }
}

TEST_F(HeightFile, damagedFilesAreNamed) {
    const std::string good = zipped(npy<int16_t>("<i2"));
    for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"cut.npz", good.substr(0, good.size() - 4)}, {"empty.npz", ""}, {"text.npz", "hello"},
                                      {"flat.npz", zipped(npy<int16_t>("<i2", "(6,)"))}, {"big.npz", zipped(npy<int16_t>("<i2", "(2000, 3000)"))}, {"huge.npz", zipped(npy<int16_t>("<i2", "(2000000000, 2000000000)"))},
                                      {"complex.npz", zipped(npy<int16_t>("<c8"))}, {"text.png", "hello"}, {"empty.exr", ""}, {"h.jpg", "x"}}) {
        try {
            readHeights(write(name, bytes), 1, 1, notes_);
            ADD_FAILURE() << name;
        } catch (const base::UsageError& e) {
            EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
        }
    }
    EXPECT_THROW(readHeights(folder_ / "none.npz", 1, 1, notes_), base::UsageError);
}

class TerrainRecipe : public HeightFile {
protected:
    Scene scene(const std::string& text, const std::vector<std::string>& settings = {}) { return readRecipe(write("t.toml", text), settings); }
};

constexpr const char* kHills = R"(
description = "hills"
trees = 300
[terrain]
size = 400
cells = 128
relief = 60
wavelength = 200
droplets = 2000
tiles = 4
detail = 60
[[species]]
name = "oak"
triangles = 600
altitude = [10, 30]
slope = 25
[[clearing]]
centre = [0, 0]
radius = 50
[[view]]
name = "v"
eye = [0, 0, 80]
target = [100, 0, 20]
)";

TEST_F(TerrainRecipe, treesKeepToTheirAltitudeSlopeAndOutOfClearings) {
    const Scene s = scene(kHills);
    size_t trees = 0;
    HeightField full;
    {
        base::ConfigTable t = base::ConfigTable::parseText("size = 400\ncells = 128\nrelief = 60\nwavelength = 200\ndroplets = 2000\n", "t");
        full = readTerrain(t, 1, 1).field;
    }
    for (const Instance& i : s.instances) {
        if (s.prototypes[i.prototype].name != "oak") continue;
        ++trees;
        EXPECT_GE(i.translation.z, 10);
        EXPECT_LE(i.translation.z, 30);
        EXPECT_GE(glm::length(glm::vec2(i.translation)), 50);
        EXPECT_NEAR(i.translation.z, full.height(i.translation.x, i.translation.y), 1e-4);
        EXPECT_LE(full.slope(i.translation.x, i.translation.y), std::tan(glm::radians(25.0)) + 1e-9);
    }
    EXPECT_EQ(trees, 300u);
}

TEST_F(TerrainRecipe, whatIsCroppedIsSaid) {
    base::writeExr(folder_ / "h.exr", {20, 17, 1, std::vector<float>(20 * 17, 5)});
    const char* recipe = "description = \"x\"\n[terrain]\nfile = \"h.exr\"\ntiles = 2\n"
                         "[[view]]\nname = \"v\"\neye = [0, 0, 80]\ntarget = [1, 0, 0]\n";
    EXPECT_THAT(scene(recipe).notes, testing::ElementsAre(testing::HasSubstr("3 columns and 0 rows")));
}

TEST_F(TerrainRecipe, farTilesAreCoarserAndAllAreClosed) {
    const Scene s = scene(kHills);
    std::set<size_t> counts;
    for (const Prototype& p : s.prototypes) {
        if (!p.name.starts_with("terrain")) continue;
        EXPECT_TRUE(p.closed) << p.name;
        counts.insert(p.triangles());
    }
    EXPECT_GT(counts.size(), 1u);
    const size_t coarse = s.facts().triangles, fine = scene(kHills, {"terrain.detail=0"}).facts().triangles;
    EXPECT_LT(coarse, fine);
}

TEST_F(TerrainRecipe, scaleMultipliesAreaAndTrees) {
    const Scene one = scene(kHills), four = scene(kHills, {"scale=4"});
    const auto trees = [](const Scene& s) {
        return std::count_if(s.instances.begin(), s.instances.end(), [&](const Instance& i) { return s.prototypes[i.prototype].name == "oak"; });
    };
    EXPECT_EQ(trees(four), 4 * trees(one));
    EXPECT_NEAR(four.facts().box.size().x, 2 * one.facts().box.size().x, 1e-2);
}

TEST_F(TerrainRecipe, badValuesNameTheLine) {
    for (const std::string setting : {"terrain.cells=8", "terrain.relief=-1", "terrain.tiles=0", "terrain.file=\"none.npz\"", "species.0.altitude=[3, 1]",
                                      "species.0.slope=90", "clearing.0.radius=-1", "scale=0", "ground.size=10"}) {
        try {
            scene(kHills, {setting});
            ADD_FAILURE() << setting;
        } catch (const base::UsageError& e) {
            EXPECT_FALSE(std::string(e.what()).empty());
        }
    }
}
