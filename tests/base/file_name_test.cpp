#include "base/file_name.h"

#include "base/expect_error.h"
#include "base/file.h"

#include <filesystem>
#include <set>

namespace dapple::base {
namespace {

namespace fs = std::filesystem;

TEST(FileName, HarmlessNamesStayAndOthersAreEscaped) {
    for (const char* same : {"forest-small", "walk0", "scale=0.1", "pcf3", "a.b", "x_1+2"})
        EXPECT_EQ(fileName(same), same);
    // tests/bench/outputs_test.py expects the same of bench/report/file_name.py.
    EXPECT_EQ(fileName("../../../../X"), "X-eb159953");
    EXPECT_EQ(fileName("scale=4; trees=3"), "scale=4-trees=3-cd39eb58");
    EXPECT_EQ(fileName("Straße"), "Stra-e-1dc32e38");
    EXPECT_EQ(fileName(""), "_-811c9dc5");
}

TEST(FileName, IsOnePartOfAPathAndNoTwoNamesShareOne) {
    std::set<std::string> seen;
    const std::string long1(300, 'a'), long2 = std::string(299, 'a') + "b";
    const std::vector<std::string> names{
        "..",       ".",    "...",     "/",   "a/b",         "c/b",          "b",    "a b", "a-b",
        "a\tb",     "a\nb", ".hidden", "-rf", "~",           "$x^{6$",       "a\\b", "",    std::string("a\0b", 3),
        "\xff\xfe", "CON:", long1,     long2, "/etc/passwd", "../etc/passwd"};
    for (const std::string& name : names) {
        const std::string part = fileName(name);
        EXPECT_TRUE(seen.insert(part).second) << name << " → " << part;
        EXPECT_LE(part.size(), 80u);
        EXPECT_EQ(part.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._=+-"),
                  std::string::npos)
            << part;
        EXPECT_NE(part.front(), '.');
        EXPECT_NE(part.front(), '-');
        EXPECT_EQ(fs::path("folder") / part, (fs::path("folder") / part).lexically_normal());
    }
}

TEST(Inputs, AreNotReplacedByWhateverPathOrLink) {
    const fs::path folder = fs::path(testing::TempDir()) / "inputs";
    fs::remove_all(folder);
    writeFile(folder / "in.obj", "v 0 0 0\n");
    writeFile(folder / "other.obj", "v 1 0 0\n");
    fs::create_symlink("in.obj", folder / "link.obj");
    fs::create_hard_link(folder / "in.obj", folder / "hard.obj");
    EXPECT_NO_THROW(requireNotAnInput(folder / "in.obj"));
    readFile(folder / "in.obj");
    for (const char* same : {"in.obj", "./in.obj", "../inputs/in.obj", "link.obj", "hard.obj"})
        expectHolds(errorLine([&] { requireNotAnInput(folder / same); }), "-o");
    EXPECT_NO_THROW(requireNotAnInput(folder / "other.obj"));
    EXPECT_NO_THROW(requireNotAnInput(folder / "new.obj"));
}

}  // namespace
}  // namespace dapple::base
