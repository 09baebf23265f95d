#include "bench/sweep.h"

#include "bench/fixture.h"

#include <set>

namespace dapple::bench {
namespace {

const std::string kHead = "question = \"?\"\nscenes = [\"a\"]\n";

std::string complaint(const std::string& toml) {
    return messageOf([&] { parseSweep(toml, "s.toml"); });
}

TEST(Sweep, ExpandsTheProductWithTheLastAxisFastest) {
    const Sweep sweep = parseSweep(kHead + "[[technique]]\nname = \"instanced\"\nrotations = [6, 12]\nsize = [128, 256]\n", "s.toml");
    std::vector<std::string> seen;
    for (const shadow::Settings& s : expand(sweep.entries.at(0))) seen.push_back(s.at("size") + "/" + s.at("rotations"));
    EXPECT_EQ(seen, (std::vector<std::string>{"128/6", "128/12", "256/6", "256/12"}));
}

TEST(Sweep, ZippedAxesAdvanceTogether) {
    const std::string head = kHead + "[[technique]]\nname = \"instanced\"\nupdate = [\"cached\", \"regenerate\"]\nzip = [\"size\", \"rotations\"]\n";
    const Sweep sweep = parseSweep(head + "size = [128, 256, 512]\nrotations = [36, 12, 4]\n", "s.toml");
    std::set<std::string> seen;
    for (const shadow::Settings& s : expand(sweep.entries.at(0))) seen.insert(s.at("size") + "/" + s.at("rotations") + "/" + s.at("update"));
    EXPECT_EQ(seen, (std::set<std::string>{"128/36/cached", "256/12/cached", "512/4/cached", "128/36/regenerate", "256/12/regenerate", "512/4/regenerate"}));
    EXPECT_NE(complaint(head + "size = [128, 256]\nrotations = [36]\n").find("equally many"), std::string::npos);
    EXPECT_NE(complaint(head + "size = [128, 256]\n").find("'rotations' is not an axis"), std::string::npos);
}

TEST(Sweep, BadInputNamesFileLineAndNearestName) {
    const auto expect = [](const std::string& toml, const std::vector<std::string>& parts) {
        const std::string line = complaint(toml);
        for (const std::string& part : parts) EXPECT_NE(line.find(part), std::string::npos) << line << " lacks " << part;
        EXPECT_EQ(line.find('\n'), std::string::npos);
    };
    expect("", {"s.toml", "empty"});
    expect("question = \"x", {"s.toml:1", "TOML"});
    expect(kHead, {"s.toml", "[[technique]]"});
    expect("question = \"?\"\n[[technique]]\nname=\"uniform\"\n", {"s.toml", "scenes", "required"});
    expect(kHead + "[[technique]]\nname = \"unifrom\"\n", {"s.toml:4", "unifrom", "'uniform'"});
    expect(kHead + "[[technique]]\nname = \"uniform\"\nsise = 3\n", {"s.toml:5", "sise", "'size'"});
    expect(kHead + "[[technique]]\nname = \"uniform\"\nsize = 0\n", {"s.toml:5", "size", "0 is outside"});
    expect(kHead + "[[technique]]\nname = \"uniform\"\nsize = 1000000\n", {"s.toml:5", "size", "1000000 is outside"});
    expect(kHead + "[[technique]]\nname = \"uniform\"\nsize = 1.5\n", {"s.toml:5", "size", "whole number"});
    expect(kHead + "[[technique]]\nname = \"uniform\"\nfilter = \"pfc2\"\n", {"s.toml:5", "filter", "'pcf2'"});
    expect(kHead + "[[technique]]\nname = \"uniform\"\nrotations = 3\n", {"s.toml:5", "rotations", "no such axis"});
    expect(kHead + "resolutoin = [1, 2]\n[[technique]]\nname = \"uniform\"\n", {"s.toml:3", "'resolution'"});
    expect(kHead + "resolution = [0, 2]\n[[technique]]\nname = \"uniform\"\n", {"s.toml:3", "resolution"});
    expect(kHead + "stress = [\"zenith\"]\n[[technique]]\nname = \"uniform\"\n", {"s.toml:3", "stress case 'zenith'"});
    expect(kHead + "[sampling]\nmin_blocks = 0\n[[technique]]\nname = \"uniform\"\n", {"s.toml:4", "min_blocks"});
    expect("question = \"?\"\nscenes = [\"a\", \"a\"]\n[[technique]]\nname = \"uniform\"\n", {"s.toml:2", "named twice"});
}

TEST(Sweep, VariantsAreListsOfSettings) {
    const std::string rest = "[[technique]]\nname = \"instanced\"\nrotations = [6, 12]\n";
    const Sweep sweep = parseSweep(kHead + "variants = [\"\", \"sun.elevation=10\", \"sun.elevation=30;  trees = 9 \"]\n" + rest, "s.toml");
    EXPECT_EQ(sweep.variants, (std::vector<std::string>{"", "sun.elevation=10", "sun.elevation=30;  trees = 9 "}));
    EXPECT_EQ(variantSettings(sweep.variants[0]), std::vector<std::string>{});
    EXPECT_EQ(variantSettings(sweep.variants[1]), std::vector<std::string>{"sun.elevation=10"});
    EXPECT_EQ(variantSettings(sweep.variants[2]), (std::vector<std::string>{"sun.elevation=30", "trees = 9"}));
    EXPECT_NE(complaint(kHead + "variants = [\"low\"]\n" + rest).find("s.toml:3: variants: 'low': write key=value"), std::string::npos);
    EXPECT_NE(complaint(kHead + "variants = [\"a=1\", \"a=1\"]\n" + rest).find("named twice"), std::string::npos);
}

TEST(Sweep, APlotIsOverAnAxisThatTheSweepSets) {
    const auto with = [](const std::string& plot) {
        return kHead + "variants = [\"\", \"a=1\"]\n[plot]\n" + plot + "\n[[technique]]\nname = \"instanced\"\nrotations = [6, 12]\nmode = [\"nearest\", \"depth\"]\n";
    };
    const Sweep sweep = parseSweep(with("x = \"rotations\"\ncolumns = \"mode\""), "s.toml");
    EXPECT_EQ(sweep.plot.x, "rotations");
    EXPECT_EQ(sweep.plot.columns, "mode");
    EXPECT_EQ(sweep.plot.y, "error");
    EXPECT_EQ(parseSweep(with("x = \"mode\"\ny = \"mean_absolute\""), "s.toml").plot.y, "mean_absolute");
    EXPECT_NE(complaint(with("x = \"mode\"\ny = \"eror\"")).find("s.toml:6: y: unknown metric 'eror'"), std::string::npos);
    EXPECT_EQ(parseSweep(with("x = \"variant\""), "s.toml").plot.x, "variant");
    EXPECT_EQ(parseSweep(kHead + "[[technique]]\nname = \"uniform\"\n", "s.toml").plot.x, "");
    EXPECT_NE(complaint(with("x = \"size\"")).find("s.toml:5: x: 'size' is neither"), std::string::npos);
    EXPECT_NE(complaint(with("x = \"mode\"\ncolumns = \"mode\"")).find("another than x"), std::string::npos);
    EXPECT_NE(complaint(with("columns = \"mode\"")).find("required"), std::string::npos);
    EXPECT_NE(complaint(kHead + "[plot]\nx = \"variant\"\n[[technique]]\nname = \"uniform\"\n").find("neither"), std::string::npos);
}

TEST(Sweep, OverridesReplaceTheAxisEverywhereItExists) {
    Sweep sweep = smallSweep();
    overrideAxis(sweep, "size=64,128,1024");
    EXPECT_EQ(expand(sweep.entries[0]).size(), 1u);  // unshadowed has no size
    EXPECT_EQ(expand(sweep.entries[1]).size(), 3u);
    EXPECT_EQ(expand(sweep.entries[2]).size(), 3u);
    overrideAxis(sweep, "filter=pcf2");
    for (const shadow::Settings& s : expand(sweep.entries[1])) EXPECT_EQ(s.at("filter"), "pcf2");
    EXPECT_NE(messageOf([&] { overrideAxis(sweep, "siez=3"); }).find("'size'"), std::string::npos);
    EXPECT_NE(messageOf([&] { overrideAxis(sweep, "rotations=3"); }).find("no technique"), std::string::npos);
    EXPECT_EQ(codeOf([&] { overrideAxis(sweep, "size"); }), base::ExitCode::usage);
    EXPECT_EQ(codeOf([&] { overrideAxis(sweep, "size=0"); }), base::ExitCode::usage);
}

TEST(Sweep, EveryNamedSweepReadsAndOpensWithItsQuestion) {
    ASSERT_GE(listSweeps().size(), 5u);
    for (const SweepFile& file : listSweeps()) {
        EXPECT_EQ(base::readFile(file.path).substr(0, 2), "# ") << file.path;
        const Sweep sweep = readSweep(file.name);
        EXPECT_FALSE(sweep.question.empty());
        for (const TechniqueEntry& entry : sweep.entries) EXPECT_FALSE(expand(entry).empty());
    }
    EXPECT_NE(messageOf([] { readSweep("quik"); }).find("'quick'"), std::string::npos);
    EXPECT_EQ(codeOf([] { readSweep("no/such.toml"); }), base::ExitCode::usage);
}

TEST(Sweep, MotionIsAPathOfTheSun) {
    const std::string tail = "[[technique]]\nname = \"uniform\"\n";
    EXPECT_FALSE(parseSweep(kHead + tail, "s.toml").path);
    const MotionPath path = parseSweep(kHead + "[motion]\nsun_azimuth_per_frame = 0.5\nsun_elevation_per_frame = -0.25\nframes = 4\n" + tail, "s.toml").path.value();
    EXPECT_EQ(path.at({100, 40}, 3).azimuth, 101.5);
    EXPECT_EQ(path.at({100, 40}, 3).elevation, 39.25);
    std::vector<int> shown;
    for (long n = 0; n < 9; ++n) shown.push_back(path.frameOf(n));
    EXPECT_EQ(shown, (std::vector<int>{0, 1, 2, 3, 2, 1, 0, 1, 2}));
    EXPECT_NE(complaint(kHead + "[motion]\nframes = 4\n" + tail).find("sun_azimuth_per_frame"), std::string::npos);
    EXPECT_NE(complaint(kHead + "[motion]\nsun_elevation_per_frame = 1\nframes = 1\n" + tail).find("frames"), std::string::npos);
    EXPECT_NE(complaint(kHead + "[motion]\nsun_elevation_per_frame = 1\nspeed = 1\n" + tail).find("speed"), std::string::npos);
}

}  // namespace
}  // namespace dapple::bench
