#include "scenegen/import/import.h"

#include "base/error.h"
#include "base/file.h"
#include "base/random.h"
#include "scenegen/import/file_access.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>

namespace dapple::scenegen {
namespace {
namespace fs = std::filesystem;

class HostileFiles : public testing::Test {
protected:
    HostileFiles() : folder_(testing::TempDir() + "dapple_hostile_" + testing::UnitTest::GetInstance()->current_test_info()->name()) {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    ~HostileFiles() override { fs::remove_all(folder_); }

    /// The one line with which the file is refused; "" if it is read.
    std::string refusal(const std::string& name, const std::string& bytes) {
        base::writeFile(folder_ / name, bytes);
        return refusal(name);
    }
    std::string refusal(const std::string& name) {
        try {
            importFile(folder_ / name);
        } catch (const base::UsageError& e) {
            EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
            return e.what();
        }
        return "";
    }

    fs::path folder_;
};

std::string repeated(const std::string& text, int times) {
    std::string all;
    for (int i = 0; i < times; ++i) all += text;
    return all;
}

std::string ply(const std::string& vertices, const std::string& data) {
    return "ply\nformat ascii 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" + data;
}

TEST_F(HostileFiles, CrashesOfReadersAreOneLine) {
    EXPECT_NE(refusal("range.ply", ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2000000000\n")), "");
    EXPECT_NE(refusal("deep.dae", "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><library_visual_scenes><visual_scene id=\"s\">" +
                                      repeated("<node id=\"n\">", 12'000) + repeated("</node>", 12'000) +
                                      "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>"), "");
    EXPECT_NE(refusal("deep.ac", "AC3Db\nMATERIAL \"\" rgb 1 1 1 amb 1 1 1 emis 0 0 0 spec 0 0 0 shi 0 trans 0\nOBJECT world\nkids 1\n" +
                                     repeated("OBJECT group\nkids 1\n", 60'000) + "OBJECT poly\nkids 0\n"), "");
    EXPECT_NE(refusal("null.raw", "1 2 3 4 5 6 7 8 9\nfoo\n"), "");
}

TEST_F(HostileFiles, RunawaysEndInTime) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_NE(refusal("never.ply", ply("4000000000", "0 0 0\n")), "");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(40));  // 8 s of processor time on a busy machine
}

TEST_F(HostileFiles, WhatIsNoFileIsRefusedAtOnce) {
    ::mkfifo((folder_ / "pipe.obj").c_str(), 0600);
    EXPECT_NE(refusal("pipe.obj").find("not a regular file"), std::string::npos);
    fs::create_directory(folder_ / "folder.obj");
    EXPECT_NE(refusal("folder.obj").find("is a folder"), std::string::npos);
    EXPECT_NE(refusal("missing.obj").find("no such file"), std::string::npos);
    EXPECT_NE(refusal("empty.obj", "").find("is empty"), std::string::npos);
}

/// A triangle in OBJ, its material from `library`.
std::string triangle(const std::string& library) {
    return "mtllib " + library + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";
}

TEST_F(HostileFiles, NothingOutsideTheFolderIsRead) {
    const std::string red = "newmtl m\nKd 1 0 0\n";
    base::writeFile(folder_ / "scene/in/m.mtl", red);
    base::writeFile(folder_ / "secret.mtl", red);
    fs::create_symlink(folder_ / "secret.mtl", folder_ / "scene/link.mtl");
    const auto isRed = [&](const std::string& library) {
        base::writeFile(folder_ / "scene/t.obj", triangle(library));
        const Scene scene = importFile(folder_ / "scene/t.obj");
        const bool found = scene.materials[0].albedo.r > 0.9f && scene.materials[0].albedo.g < 0.1f;
        EXPECT_EQ(scene.notes.empty(), found) << library;
        return found;
    };
    const std::vector<std::string> outside{"../secret.mtl", "link.mtl", "in/../../secret.mtl"};
    EXPECT_TRUE(isRed("in/m.mtl"));
    for (const std::string& library : outside) EXPECT_FALSE(isRed(library)) << library;
    base::writeFile(folder_ / "scene/t.obj", triangle((folder_ / "secret.mtl").string()));
    EXPECT_LT(importFile(folder_ / "scene/t.obj").materials[0].albedo.r, 0.9f);
    allowOutside(true);
    for (const std::string& library : outside) EXPECT_TRUE(isRed(library)) << library;
    allowOutside(false);
}

TEST_F(HostileFiles, SidecarsReachNoFurther) {
    base::writeFile(folder_ / "scene/t.obj", triangle("m.mtl"));
    base::writeFile(folder_ / "scene/t.toml", "textures = [\"../other\"]\n");
    EXPECT_THROW(importFile(folder_ / "scene/t.obj"), base::UsageError);
    base::writeFile(folder_ / "scene/t.toml", "textures = [\"below\"]\n");
    EXPECT_NO_THROW(importFile(folder_ / "scene/t.obj"));
}

TEST_F(HostileFiles, CoordinatesBeyondAllMeasureAreRefused) {
    for (const char* far : {"3e38", "1e30", "-4e9", "1e300"})
        EXPECT_NE(refusal("far.obj", fmt::format("v 0 0 0\nv {} 0 0\nv 0 {} 0\nf 1 2 3\n", far, far)), "") << far;
}

/// One small scene in formats that other people's readers read, each damaged at random places: it is read or refused, and
/// nothing else happens. (A crash of this process, or an exception of another kind, fails the test.)
TEST_F(HostileFiles, DamagedFilesAreReadOrRefused) {
    const std::string ascii = ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    std::string stl(84 + 50, '\0');
    stl[80] = 1;
    for (int k = 0; k < 3; ++k) stl[size_t(84 + 12 + 12 * k + 4 * k + 3)] = 0x3f;  // one coordinate of each corner
    const std::vector<std::pair<std::string, std::string>> files{
        {"a.ply", ascii},
        {"a.stl", stl},
        {"a.obj", triangle("a.mtl") + "f 1 2 3\nf -1 -2 -3\n"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {"a.raw", "0 0 0 1 0 0 0 1 0\n"},
        {"a.ac", "AC3Db\nMATERIAL \"\" rgb 1 1 1 amb 1 1 1 emis 0 0 0 spec 0 0 0 shi 0 trans 0\nOBJECT world\nkids 1\nOBJECT poly\nnumvert 3\n"
                 "0 0 0\n1 0 0\n0 1 0\nnumsurf 1\nSURF 0x20\nmat 0\nrefs 3\n0 0 0\n1 1 0\n2 0 1\nkids 0\n"},
        {"a.x", "xof 0303txt 0032\nMesh m {\n3;\n0;0;0;,\n1;0;0;,\n0;1;0;;\n1;\n3;0,1,2;;\n}\n"},
    };
    base::Random random(20261129, 1, 2);
    int read = 0, refused = 0;
    for (const auto& [name, good] : files)
        for (int round = 0; round < 24; ++round) {
            std::string bad = good;
            for (int k = round % 4; k >= 0 && round > 0; --k) {
                const size_t at = size_t(random.next(0, float(bad.size())));
                switch (int(random.next(0, 4))) {
                    case 0: bad[at] = char(int(random.next(0, 256))); break;
                    case 1: bad.insert(at, std::string(1 + size_t(random.next(0, 9)), "9-e. \n{0\xff"[int(random.next(0, 9))])); break;
                    case 2: bad.erase(at, size_t(random.next(0, 12))); break;
                    default: bad += bad.substr(at); break;
                }
                if (bad.empty()) bad = "x";
            }
            SCOPED_TRACE(testing::Message() << name << " of round " << round);
            ++(refusal(name, bad).empty() ? read : refused);
        }
    EXPECT_GE(read, int(files.size()));  // those of round 0 are whole
    EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace dapple::scenegen
