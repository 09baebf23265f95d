#include "frame/pass.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace dapple::frame {
namespace {

Pass pass(std::string name, std::vector<std::string> reads, std::vector<std::string> writes, std::string leftOut = "") {
    return {std::move(name), std::move(reads), std::move(writes), "", std::move(leftOut), {}};
}
std::string errorOf(const std::vector<Pass>& passes, const std::vector<std::string>& imports = {}) {
    try {
        check(passes, imports);
    } catch (const std::logic_error& e) {
        return e.what();
    }
    return "";
}

TEST(Check, AcceptsReadsOfWhatIsWritten) {
    const std::vector<Pass> passes{pass("gbuffer", {}, {"depth", "normals"}), pass("map", {}, {"map"}),
                                   pass("resolve", {"map", "depth"}, {"visibility"}), pass("blur", {"visibility"}, {"visibility"})};
    EXPECT_EQ(errorOf(passes), "");
    EXPECT_EQ(errorOf({}), "");
}

TEST(Check, NamesPassAndResourceOfAReadBeforeWrite) {
    const std::string line = errorOf({pass("gbuffer", {}, {"depth"}), pass("resolve", {"depth", "map"}, {}), pass("late", {}, {"map"})});
    EXPECT_NE(line.find("resolve"), std::string::npos) << line;
    EXPECT_NE(line.find("map"), std::string::npos) << line;
    EXPECT_NE(errorOf({pass("self", {"a"}, {"a"})}), "");  // its own writes come too late
}

TEST(Check, ImportsCountAsWritten) {
    const std::vector<Pass> passes{pass("resolve", {"map"}, {})};
    EXPECT_NE(errorOf(passes), "");
    EXPECT_EQ(errorOf(passes, {"map"}), "");
    EXPECT_NE(errorOf(passes, {"other"}), "");
}

TEST(Check, LeftOutPassesNeitherReadNorWrite) {
    EXPECT_EQ(errorOf({pass("alpha", {"nothing"}, {}, "no alpha-tested caster")}), "");
    EXPECT_NE(errorOf({pass("map", {}, {"map"}, "sun below the horizon"), pass("resolve", {"map"}, {})}), "");
}

TEST(RunningPasses, AreThoseNotLeftOutInOrder) {
    EXPECT_EQ(runningPasses(std::vector<Pass>{pass("a", {}, {}), pass("b", {}, {}, "why"), pass("c", {}, {}), pass("a", {}, {})}),
              (std::vector<std::string>{"a", "c", "a"}));
}

}  // namespace
}  // namespace dapple::frame
