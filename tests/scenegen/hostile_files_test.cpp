#include "scenegen/import/import.h"

#include "base/error.h"
#include "base/file.h"

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

}  // namespace
}  // namespace dapple::scenegen
