#include "scenegen/import/file_kind.h"

#include "base/error.h"
#include "base/file.h"
#include "scenegen/export/glb.h"
#include "scenegen/library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

using namespace dapple;
using namespace dapple::scenegen;
using testing::HasSubstr;
namespace fs = std::filesystem;

namespace {

constexpr const char* kRecipe = "description = \"a box\"\n[[primitive]]\nkind = \"box\"\nposition = [0, 0, 2]\nsize = [3, 4, 4]\n"
                                "[[view]]\nname = \"v\"\neye = [0, -20, 2]\ntarget = [0, 0, 2]\n";

class FileKinds : public testing::Test {
protected:
    fs::path folder_ = fs::temp_directory_path() / ("dapple-kinds-" + std::to_string(getpid()));
    FileKinds() { fs::create_directories(folder_); }
    ~FileKinds() override { fs::remove_all(folder_); }

    fs::path write(const std::string& name, const std::string& text) {
        base::writeFile(folder_ / name, text);
        return folder_ / name;
    }
    std::string errorOf(const fs::path& file) {
        try {
            loadScene(file.string());
        } catch (const base::UsageError& e) {
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
            return e.what();
        }
        return "no error";
    }
};

}  // namespace

TEST_F(FileKinds, aRecipeBesideAnExportedSceneIsNotItsSidecar) {
    const Scene town = loadScene(write("town.toml", kRecipe).string());
    for (const char* name : {"town.glb", "town.GLB"}) {
        writeGlb(town, folder_ / name);
        EXPECT_FALSE(hasSidecar(folder_ / name));
        EXPECT_EQ(loadScene((folder_ / name).string()).facts().triangles, 12u);
    }
    // A sidecar still is one, also when it says no more than sun and views, and its slips are still refused.
    write("town.toml", "[sun]\nelevation = 11\n");
    EXPECT_TRUE(hasSidecar(folder_ / "town.glb"));
    EXPECT_EQ(loadScene((folder_ / "town.glb").string()).sun.elevation, 11);
    write("town.toml", "description = \"x\"\nunit = 2\n");
    EXPECT_THAT(errorOf(folder_ / "town.glb"), HasSubstr("unknown key 'description'"));
    write("town.toml", "untis = 2\n");
    EXPECT_THAT(errorOf(folder_ / "town.glb"), HasSubstr("unknown key 'untis'"));
}

TEST_F(FileKinds, recipesAndSidecarsAreKnownByTheirKeys) {
    EXPECT_EQ(fileKind(write("a.toml", kRecipe)), FileKind::recipe);
    EXPECT_EQ(fileKind(write("a.tml", kRecipe)), FileKind::recipe);
    EXPECT_EQ(fileKind(write("recipe", kRecipe)), FileKind::recipe);
    EXPECT_EQ(fileKind(write("b.toml", "up = \"z\"\n")), FileKind::sidecar);
    EXPECT_EQ(fileKind(write("c.toml", "")), FileKind::recipe);
    EXPECT_EQ(fileKind(write("d.obj", "v 0 0 0\n")), FileKind::scene);
    EXPECT_EQ(fileKind(write("e.GeoJSON", "{}")), FileKind::footprints);
    EXPECT_EQ(loadScene((folder_ / "a.tml").string()).facts().triangles, 12u);
    EXPECT_THAT(errorOf(folder_ / "b.toml"), HasSubstr("says how to read a scene file of the same name"));
    EXPECT_THAT(errorOf(folder_ / "c.toml"), HasSubstr("description: is required"));
}

TEST_F(FileKinds, aMissingFileNamesTheOneThatIsMeant) {
    write("mine.toml", kRecipe);
    EXPECT_THAT(errorOf(folder_ / "mine.tml"), HasSubstr("mine.tml: no such file; did you mean 'mine.toml'?"));
    EXPECT_THAT(errorOf(folder_ / "mime.toml"), HasSubstr("mime.toml: no such file; did you mean 'mine.toml'?"));
    EXPECT_THAT(errorOf(folder_ / "gone.obj"), testing::EndsWith("gone.obj: no such file"));
    EXPECT_THAT(errorOf(folder_ / "none/gone.obj"), testing::EndsWith("gone.obj: no such file"));
}

TEST_F(FileKinds, pipesAndFoldersAreRefused) {
    for (const char* name : {"pipe.toml", "pipe.geojson", "pipe.glb", "pipe"}) {
        ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
        EXPECT_THAT(errorOf(folder_ / name), HasSubstr("is a pipe or a device"));
    }
    const fs::path recipe = write("town.toml", "description = \"x\"\n[city]\nfootprints = \"pipe.geojson\"\n");
    EXPECT_THAT(errorOf(recipe), HasSubstr("pipe.geojson is a pipe or a device"));
    fs::create_directories(folder_ / "folder.obj");
    EXPECT_THAT(errorOf(folder_ / "folder.obj"), HasSubstr("is a folder"));
    EXPECT_THAT(errorOf("/dev/zero"), HasSubstr("is a pipe or a device"));
}
