#include "base/config.h"

#include "base/expect_error.h"
#include "base/file.h"

#include <filesystem>

namespace dapple::base {
namespace {

ConfigTable parse(std::string_view text) { return ConfigTable::parseText(text, "some.toml"); }

/// The error of reading `text`, which must hold every one of `parts`.
template <class F>
void expectError(std::string_view text, const F& read, std::initializer_list<const char*> parts) {
    const std::string line = errorLine([&] {
        ConfigTable table = parse(text);
        read(table);
    });
    for (const char* part : parts) expectHolds(line, part);
}

TEST(ConfigTable, ReadsEveryType) {
    ConfigTable t = parse("a = 'word'\nb = 2.5\nc = 7\nd = true\ne = [1, 2.5, -3]\nf = [1, 2.50, 'x', true]\ng = 9\n");
    EXPECT_EQ(t.text("a"), "word");
    EXPECT_EQ(t.text("a", "other"), "word");
    EXPECT_EQ(t.number("b"), 2.5);
    EXPECT_EQ(t.number("b", 1, 0, 3), 2.5);
    EXPECT_EQ(t.number("c", 0), 7);  // a whole number is a number
    EXPECT_EQ(t.integer("c", 0, 0, 10), 7);
    EXPECT_TRUE(t.boolean("d", false));
    EXPECT_EQ(t.numbers("e", 3), (std::vector<double>{1, 2.5, -3}));
    EXPECT_EQ(t.numbers("e", 0).size(), 3u);
    EXPECT_EQ(t.values("f"), (std::vector<std::string>{"1", "2.5", "x", "true"}));
    EXPECT_EQ(t.values("g"), std::vector<std::string>{"9"});
    EXPECT_NO_THROW(t.finish());
}

TEST(ConfigTable, MissingKeysYieldTheDefault) {
    ConfigTable t = parse("");
    EXPECT_EQ(t.text("a", "other"), "other");
    EXPECT_EQ(t.number("b", 1.5, 0, 1), 1.5);
    EXPECT_EQ(t.integer("c", 3, 0, 10), 3);
    EXPECT_TRUE(t.boolean("d", true));
    EXPECT_FALSE(t.table("e"));
    EXPECT_TRUE(t.tables("f").empty());
    EXPECT_FALSE(t.has("g"));
}

TEST(ConfigTable, MissingRequiredKeysAreNamed) {
    expectError("", [](ConfigTable& t) { t.text("alpha"); }, {"some.toml", "alpha", "is required"});
    expectError("", [](ConfigTable& t) { t.number("alpha"); }, {"some.toml", "alpha", "is required"});
    expectError("", [](ConfigTable& t) { t.values("alpha"); }, {"some.toml", "alpha", "is required"});
    expectError("", [](ConfigTable& t) { t.numbers("alpha", 2); }, {"some.toml", "alpha", "array of 2 numbers"});
}

TEST(ConfigTable, WrongTypesAreNamedWithTheirLine) {
    const char* text = "\na = 1\nb = 'x'\nc = [1, 'x']\nd = { e = 1 }\nf = 1.0\n[[g]]\nh = 1\n";
    expectError(text, [](ConfigTable& t) { t.text("a"); }, {"some.toml:2:", "a: ", "text"});
    expectError(text, [](ConfigTable& t) { t.text("a", "z"); }, {"some.toml:2:", "text"});
    expectError(text, [](ConfigTable& t) { t.number("b"); }, {"some.toml:3:", "b: ", "number"});
    expectError(text, [](ConfigTable& t) { t.number("b", 1); }, {"some.toml:3:", "number"});
    expectError(text, [](ConfigTable& t) { t.integer("b", 1, 0, 2); }, {"some.toml:3:", "whole number"});
    expectError(text, [](ConfigTable& t) { t.integer("f", 1, 0, 2); }, {"some.toml:6:", "whole number"});
    expectError(text, [](ConfigTable& t) { t.boolean("a", true); }, {"some.toml:2:", "true or false"});
    expectError(text, [](ConfigTable& t) { t.number("d"); }, {"some.toml:5:", "number"});
    expectError("a = true", [](ConfigTable& t) { t.number("a"); }, {"some.toml:1:", "number"});
    expectError(text, [](ConfigTable& t) { t.numbers("a", 0); }, {"some.toml:2:", "array"});
    expectError(text, [](ConfigTable& t) { t.numbers("c", 0); }, {"some.toml:4:", "number"});
    expectError(text, [](ConfigTable& t) { t.numbers("c", 3); }, {"some.toml:4:", "array of 3"});
    expectError(text, [](ConfigTable& t) { t.values("d"); }, {"some.toml:5:", "values"});
    expectError(text, [](ConfigTable& t) { t.table("a"); }, {"some.toml:2:", "table"});
    expectError(text, [](ConfigTable& t) { t.tables("d"); }, {"some.toml:5:", "[[d]]"});
    expectError(text, [](ConfigTable& t) { t.tables("c"); }, {"some.toml:4:", "[[c]]"});
    expectError("a = [[1], 2]", [](ConfigTable& t) { t.values("a"); }, {"some.toml:1:", "a: "});
    expectError("a = []", [](ConfigTable& t) { t.values("a"); }, {"some.toml:1:", "empty"});
}

TEST(ConfigTable, RangesIncludeTheirEnds) {
    ConfigTable t = parse("a = 2\nb = 5\nc = 0.5");
    EXPECT_EQ(t.integer("a", 0, 2, 5), 2);
    EXPECT_EQ(t.integer("b", 0, 2, 5), 5);
    EXPECT_EQ(t.number("c", 0, 0.5, 0.5), 0.5);
    expectError("\nx = 6", [](ConfigTable& u) { u.integer("x", 2, 2, 5); }, {"some.toml:2:", "x: ", "6", "2 … 5"});
    expectError("x = 1", [](ConfigTable& u) { u.integer("x", 2, 2, 5); }, {"some.toml:1:", "2 … 5"});
    expectError("x = 5.001", [](ConfigTable& u) { u.number("x", 2, 2, 5); }, {"some.toml:1:", "5.001", "2 … 5"});
    expectError("x = 1", [](ConfigTable& u) { u.number("x", 2, 2, 5); }, {"some.toml:1:", "2 … 5"});
}

TEST(ConfigTable, NumbersMustBeFinite) {
    for (const char* text : {"x = nan", "x = inf", "x = -inf"}) {
        expectError(text, [](ConfigTable& t) { t.number("x"); }, {"some.toml:1:", "x: ", "finite"});
        expectError(text, [](ConfigTable& t) { t.number("x", 0); }, {"finite"});
        expectError(text, [](ConfigTable& t) { t.values("x"); }, {"finite"});
    }
    expectError("\n\nx = [1,\n nan]", [](ConfigTable& t) { t.numbers("x", 2); }, {"some.toml:4:", "finite"});
}

TEST(ConfigTable, UnknownKeysAreNamedWithLineAndNearest) {
    const auto read = [](ConfigTable& t) {
        t.integer("trees", 1, 0, 100);
        t.number("radius", 1);
        t.finish();
    };
    expectError("radius = 1\n\ntress = 5\n", read, {"some.toml:3:", "'tress'", "did you mean 'trees'?", "known: radius, trees"});
    expectError("zebra = 5\n", read, {"some.toml:1:", "'zebra'", "known: radius, trees"});
    expectError("[radiuss]\n", read, {"some.toml:1:", "did you mean 'radius'?"});
    ConfigTable asked = parse("trees = 5");
    EXPECT_TRUE(asked.has("trees"));  // asking counts as knowing
    EXPECT_NO_THROW(asked.finish());
}

TEST(ConfigTable, InvalidTomlIsNamedWithItsLine) {
    for (const char* text : {"a = 1\nb = = 2\n", "a = 1\na = 2\n", "a = 1\n[b\n", "a = 1\nb = 'x\n"})
        expectHolds(errorLine([&] { parse(text); }), "some.toml:2: not valid TOML: ");
}

TEST(ConfigTable, SubTablesAreTablesOfTheirOwn) {
    ConfigTable root = parse("name = 'x'\n[sun]\nazimuth = 90\nelevatoin = 3\n");
    std::optional<ConfigTable> sun = root.table("sun");
    ASSERT_TRUE(sun);
    EXPECT_EQ(sun->number("azimuth"), 90);
    sun->number("elevation", 45);
    const std::string line = errorLine([&] { sun->finish(); });
    expectHolds(line, "some.toml:4:");
    expectHolds(line, "did you mean 'elevation'?");
    root.text("name");
    EXPECT_NO_THROW(root.finish());
}

TEST(ConfigTable, ArraysOfTablesKeepTheirOrderAndOutliveTheirRoot) {
    std::vector<ConfigTable> species;
    {
        ConfigTable root = parse("[[species]]\nname = 'oak'\n[[species]]\nname = 'fir'\n\nheight = -1\n");
        species = root.tables("species");
        root.finish();
    }
    ASSERT_EQ(species.size(), 2u);
    EXPECT_EQ(species[0].text("name"), "oak");
    EXPECT_EQ(species[1].text("name"), "fir");
    expectHolds(errorLine([&] { species[1].number("height", 1, 0, 9); }), "some.toml:6: height: ");
    expectHolds(errorLine([&] { species[0].fail("name", "is not a tree"); }), "some.toml:2: name: is not a tree");
}

TEST(ConfigTable, KeysComeInTheOrderOfTheLines) {
    EXPECT_EQ(parse("zebra = 1\nant = 2\nmole = 3\n").keys(), (std::vector<std::string>{"zebra", "ant", "mole"}));
}

TEST(ConfigTable, SetReplacesAddsAndNamesItself) {
    ConfigTable root = parse("trees = 5\n[ground]\nsize = 3\n[[species]]\nname = 'oak'\n");
    root.set("trees=9");
    root.set("ground.size=50.5");
    root.set("species.0.name=fir");
    root.set("extra=[1, 2]");
    EXPECT_EQ(root.integer("trees", 0, 0, 10), 9);
    EXPECT_EQ(root.table("ground")->number("size"), 50.5);
    EXPECT_EQ(root.tables("species")[0].text("name"), "fir");
    EXPECT_EQ(root.numbers("extra", 2), (std::vector<double>{1, 2}));
    root.set("trees=900");
    expectHolds(errorLine([&] { root.integer("trees", 0, 0, 10); }), "setting 'trees=900': trees: 900 is outside 0 … 10");
    expectHolds(errorLine([&] { root.set("trees.x=1"); }), "trees.x=1");
    expectHolds(errorLine([&] { root.set("trees"); }), "key=value");
    expectHolds(errorLine([&] { root.set("=1"); }), "key=value");
}

TEST(ConfigTable, SetReachesTablesThatTheFileLeavesOut) {
    ConfigTable root = parse("[[species]]\nname = 'oak'\n");
    root.set("wind.strength=0.8");
    root.set("wind.direction=90");
    root.set("species.1.name=fir");
    root.set("view.0.lens.fovY=50");
    std::optional<ConfigTable> wind = root.table("wind");
    ASSERT_TRUE(wind);
    EXPECT_EQ(wind->number("strength"), 0.8);
    EXPECT_EQ(wind->number("direction"), 90);
    EXPECT_EQ(root.tables("species").at(1).text("name"), "fir");
    EXPECT_EQ(root.tables("view").at(0).table("lens")->number("fovY"), 50);
    EXPECT_NO_THROW(root.finish());
    // What nobody knows is still refused, with the nearest name and the setting.
    root.set("wnd.strength=1");
    const std::string line = errorLine([&] { root.finish(); });
    expectHolds(line, "setting 'wnd.strength=1': unknown key 'wnd'");
    expectHolds(line, "did you mean 'wind'?");
    root.set("wind.strnegth=1");
    std::optional<ConfigTable> misspelt = root.table("wind");
    misspelt->number("strength");
    misspelt->number("direction");
    expectHolds(errorLine([&] { misspelt->finish(); }),
                "setting 'wind.strnegth=1': unknown key 'strnegth'; did you mean 'strength'?");
    expectHolds(errorLine([&] { root.set("species.7.name=x"); }), "species.7.name=x");
    expectHolds(errorLine([&] { root.set("species.name=x"); }), "species.name=x");
}

TEST(ConfigTable, PathsCountFromTheFileOrInSettingsFromTheWorkingFolder) {
    ConfigTable t = ConfigTable::parseText("a = 'x/one.png'\nb = '/abs/two.png'\n[c]\nd = 'three'\n[[e]]\nf = 'four'\n", "folder/some.toml");
    t.set("g=five.png");
    t.set("c.h=six");
    EXPECT_EQ(t.path("a"), "folder/x/one.png");
    EXPECT_EQ(t.path("b"), "/abs/two.png");
    EXPECT_EQ(t.path("g"), "five.png");
    ConfigTable c = *t.table("c");
    EXPECT_EQ(c.path("d"), "folder/three");
    EXPECT_EQ(c.path("h"), "six");
    EXPECT_EQ(t.tables("e")[0].path("f"), "folder/four");
    EXPECT_EQ(parse("a = 'one'").path("a"), "one");
    expectError("a = 3", [](ConfigTable& table) { table.path("a"); }, {"some.toml:1: a: must be a text"});
}

TEST(ConfigTable, FilesAreNamedByTheirPath) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "dapple_config_test.toml";
    writeFile(path, "a = 1\nb = nan\n");
    ConfigTable t = ConfigTable::parseFile(path);
    EXPECT_EQ(t.integer("a", 0, 0, 2), 1);
    expectHolds(errorLine([&] { t.number("b"); }), path.string() + ":2: b: ");
    std::filesystem::remove(path);
    expectHolds(errorLine([&] { ConfigTable::parseFile(path); }), path.string());
}

}  // namespace
}  // namespace dapple::base
