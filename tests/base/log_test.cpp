#include "base/log.h"

#include <gtest/gtest.h>

namespace dapple::base {
namespace {

TEST(Printable, TextStaysAsItIs) {
    for (const char* text : {"", "a b", "blätter", "\xe6\xa8\xb9.obj", "\xf0\x9f\x8c\xb3"}) EXPECT_EQ(printable(text), text);
}

TEST(Printable, ControlCharactersAreShown) {
    EXPECT_EQ(printable("a\x1b[2Jb\r\n\x7f"), "a\\x1b[2Jb\\x0d\\x0a\\x7f");
    EXPECT_EQ(printable("\xc2\x9b" "2J"), "\\xc2\\x9b2J");  // CSI as one character
}

TEST(Printable, BytesThatAreNotUtf8AreShown) {
    EXPECT_EQ(printable("\xff.obj"), "\\xff.obj");
    EXPECT_EQ(printable("\x9b" "2J"), "\\x9b2J");
    EXPECT_EQ(printable("end\xe6\xa8"), "end\\xe6\\xa8");
    EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");                  // longer than need be
    EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");      // half of a pair
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond U+10FFFF
}

}  // namespace
}  // namespace dapple::base
