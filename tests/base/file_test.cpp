#include "base/file.h"

#include "base/expect_error.h"

#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace dapple::base {
namespace {
namespace fs = std::filesystem;

/// A fresh folder for each test. The tests may run as root, whom permission bits do not stop: failures are provoked by
/// paths that nobody can write.
class FileTest : public ::testing::Test {
protected:
    FileTest() {
        std::string pattern = (fs::path(testing::TempDir()) / "dapple_file_XXXXXX").string();
        folder_ = ::mkdtemp(pattern.data());
    }
    ~FileTest() override { fs::remove_all(folder_); }
    size_t entries() const { return size_t(std::distance(fs::recursive_directory_iterator(folder_), fs::recursive_directory_iterator{})); }

    fs::path folder_;
};

TEST_F(FileTest, WritesAndReadsAnyBytes) {
    std::string bytes;
    for (int i = 0; i < 70'000; ++i) bytes += char(i * 7);
    writeFile(folder_ / "a/b/c.bin", bytes);  // makes the folders
    EXPECT_EQ(readFile(folder_ / "a/b/c.bin"), bytes);
    writeFile(folder_ / "a/b/c.bin", "short");
    EXPECT_EQ(readFile(folder_ / "a/b/c.bin"), "short");
    writeFile(folder_ / "empty", "");
    EXPECT_EQ(readFile(folder_ / "empty"), "");
    EXPECT_EQ(entries(), 4u);  // two folders, two files, no temporary
}

TEST_F(FileTest, FailedWritesLeaveNothing) {
    writeFile(folder_ / "file", "x");
    expectHolds(errorLine([&] { writeFile(folder_ / "file/below.csv", "y"); }), (folder_ / "file").string());
    fs::create_directory(folder_ / "taken");
    expectHolds(errorLine([&] { writeFile(folder_ / "taken", "y"); }), (folder_ / "taken").string());
    expectHolds(errorLine([&] { writeFile("/proc/dapple.csv", "y"); }), "/proc/dapple.csv");
    expectHolds(errorLine([&] { writeFile(folder_ / std::string(300, 'n'), "y"); }), "File name too long");
    EXPECT_EQ(entries(), 2u);
    EXPECT_EQ(readFile(folder_ / "file"), "x");
}

// A limit on the size of files stands in for a full disk: the write stops half-way.
TEST_F(FileTest, AFullDiskKeepsTheOldContent) {
    writeFile(folder_ / "rows.csv", "old");
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{64 * 1024, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string line = errorLine([&] { writeFile(folder_ / "rows.csv", std::string(1 << 20, 'x')); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, oldHandler);
    expectHolds(line, (folder_ / "rows.csv").string());
    expectHolds(line, "File too large");
    EXPECT_EQ(readFile(folder_ / "rows.csv"), "old");
    EXPECT_EQ(entries(), 1u);
}

TEST_F(FileTest, UnreadableFilesAreNamed) {
    expectHolds(errorLine([&] { readFile(folder_ / "missing.toml"); }), (folder_ / "missing.toml").string());
    expectHolds(errorLine([&] { readFile(folder_); }), "is a folder");
    writeFile(folder_ / "file", "x");
    expectHolds(errorLine([&] { readFile(folder_ / "file/below"); }), "Not a directory");
    expectHolds(errorLine([&] { readFile(folder_ / std::string(300, 'n')); }), "File name too long");
    expectHolds(errorLine([&] { readFile("/proc/self/mem"); }), "/proc/self/mem");  // opens, then fails to read
}

TEST_F(FileTest, RequireWritableFolder) {
    requireWritableFolder(folder_ / "new/deep");
    EXPECT_TRUE(fs::is_directory(folder_ / "new/deep"));
    EXPECT_TRUE(fs::is_empty(folder_ / "new/deep"));
    writeFile(folder_ / "file", "x");
    expectHolds(errorLine([&] { requireWritableFolder(folder_ / "file"); }), (folder_ / "file").string());
    expectHolds(errorLine([&] { requireWritableFolder("/proc/dapple"); }), "/proc/dapple");
}

TEST_F(FileTest, HomeAndCacheFollowTheEnvironment) {
    ::unsetenv("DAPPLE_HOME");
    ::unsetenv("DAPPLE_CACHE");
    EXPECT_TRUE(fs::is_directory(homeFolder() / "shaders" / "passes"));
    EXPECT_EQ(cacheFolder(), homeFolder() / "cache");
    ::setenv("DAPPLE_HOME", folder_.c_str(), 1);
    EXPECT_EQ(homeFolder(), folder_);
    EXPECT_EQ(cacheFolder(), folder_ / "cache");
    ::setenv("DAPPLE_CACHE", "/elsewhere", 1);
    EXPECT_EQ(cacheFolder(), "/elsewhere");
    ::unsetenv("DAPPLE_HOME");
    ::unsetenv("DAPPLE_CACHE");
}

}  // namespace
}  // namespace dapple::base
