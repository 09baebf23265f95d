#include "base/error.h"

#include <gtest/gtest.h>

#include <vector>

namespace dapple::base {
namespace {

const std::vector<std::string> kKnown{"uniform", "focused", "lispsm", "cascaded", "instanced"};

TEST(NearestName, FindsWhatWasMeant) {
    EXPECT_EQ(nearestName("unifrom", kKnown), "uniform");    // two letters swapped
    EXPECT_EQ(nearestName("lipsm", kKnown), "lispsm");       // one left out
    EXPECT_EQ(nearestName("cascadded", kKnown), "cascaded"); // one too many
    EXPECT_EQ(nearestName("instanced", kKnown), "instanced");
}

TEST(NearestName, PrefersTheNearer) {
    const std::vector<std::string> sizes{"pcf2", "pcf33", "pcf3"};
    EXPECT_EQ(nearestName("pcf3x", sizes), "pcf33");  // first of two at distance 1
    EXPECT_EQ(nearestName("pcf", sizes), "pcf2");
    EXPECT_EQ(nearestName("pcf3", sizes), "pcf3");
}

TEST(NearestName, IsEmptyWhenNothingIsNear) {
    EXPECT_EQ(nearestName("banana", kKnown), "");
    EXPECT_EQ(nearestName("", kKnown), "");
    EXPECT_EQ(nearestName("uniform", {}), "");
    const std::vector<std::string> letters{"ab", "x"};
    EXPECT_EQ(nearestName("qz", letters), "");  // as many edits as letters: nothing in common
}

TEST(UnknownName, NamesKindNameHintAndAllKnown) {
    EXPECT_EQ(unknownName("technique", "unifrom", kKnown),
              "unknown technique 'unifrom'; did you mean 'uniform'? (known: uniform, focused, lispsm, cascaded, instanced)");
    EXPECT_EQ(unknownName("technique", "banana", kKnown),
              "unknown technique 'banana' (known: uniform, focused, lispsm, cascaded, instanced)");
}

TEST(UsageError, CarriesItsCode) {
    EXPECT_EQ(int(UsageError("x").code()), 2);
    EXPECT_STREQ(UsageError("a line").what(), "a line");
    EXPECT_EQ(int(Error(ExitCode::interrupted, "x").code()), 130);
}

}  // namespace
}  // namespace dapple::base
