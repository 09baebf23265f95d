#include "base/terminal.h"

#include <gtest/gtest.h>

#include <sstream>

namespace dapple::base {
namespace {

TEST(Terminal, ShortensByCharacters) {
    EXPECT_EQ(shortened("abcdef", 6), "abcdef");
    EXPECT_EQ(shortened("abcdef", 5), "abcd…");
    EXPECT_EQ(shortened("äöüäöü", 3), "äö…");
    EXPECT_EQ(shortened("abc", 1), "…");
    EXPECT_EQ(shortened("abc", 0), "");
    for (size_t columns = 0; columns < 10; ++columns) EXPECT_LE(textWidth(shortened("Größe in m²", columns)), columns);
}

TEST(Terminal, WrapsBetweenWords) {
    EXPECT_EQ(wrapWords("one two three", 7), "one two\nthree");
    EXPECT_EQ(wrapWords("one two three", 8, "  "), "one two\n  three");
    EXPECT_EQ(wrapWords("  dapple run x -a size=1", 14, "      ", " \\"),
              "  dapple run \\\n      x -a \\\n      size=1");
    EXPECT_EQ(wrapWords("one\n\ntwo three\n", 5), "one\n\ntwo\nthree\n");
    EXPECT_EQ(wrapWords("unbreakable word", 4), "unbreakable\nword");
    EXPECT_EQ(wrapWords("", 10), "");
    const std::string text = "where a 2048² cascade errs: red is false shadow, blue false light";
    for (size_t columns = 10; columns < 80; ++columns) {
        std::istringstream lines(wrapWords(text, columns));
        std::string joined;
        for (std::string line; std::getline(lines, line);) {
            EXPECT_LE(textWidth(line), columns);
            joined += (joined.empty() ? "" : " ") + line;
        }
        EXPECT_EQ(joined, text);
    }
}

}  // namespace
}  // namespace dapple::base
