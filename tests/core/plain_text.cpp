#include "turgor/core/plain_text.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Letters of all languages, tabs and line ends stay as they are.
TEST(PlainText, KeepsReadableText) {
  const std::string text = "Kräfte [mm²], 力, 🫁, עור\tand\nmore";
  EXPECT_EQ(plain_text(text), text);
  EXPECT_EQ(plain_text("a\r\nb\r\n"), "a\nb\n");
  EXPECT_EQ(plain_text(""), "");
}

// Every control character and every mark that reorders a line becomes one U+FFFD.
TEST(PlainText, ReplacesTextThatSteersTerminal) {
  for (int code = 0; code < 0xa0; code++) {
    const bool ascii = code < 0x80, shown = (code >= 0x20 && code < 0x7f) || code == '\n' || code == '\t';
    const std::string character = ascii ? std::string(1, char(code)) : std::string("\xc2") + char(code);
    EXPECT_EQ(plain_text("a" + character + "b"), shown ? "a" + character + "b" : "a\uFFFDb") << code;
  }
  for (const char* mark : {"\u061c", "\u200e", "\u200f", "\u2028", "\u2029", "\u202a", "\u202b", "\u202c",
                           "\u202d", "\u202e", "\u2066", "\u2067", "\u2068", "\u2069"})
    EXPECT_EQ(plain_text(std::string("a") + mark + "b"), "a\uFFFDb") << mark;
}

// Each byte that is not UTF-8 becomes one U+FFFD: raw C1 bytes, cut, overlong and surrogate characters.
TEST(PlainText, ReplacesInvalidBytes) {
  EXPECT_EQ(plain_text("\x9b"
                       "2J"),
            "\uFFFD2J");
  EXPECT_EQ(plain_text("a\xe2\x82z"), "a\uFFFD\uFFFDz");
  EXPECT_EQ(plain_text("\xc0\xbc"), "\uFFFD\uFFFD");
  EXPECT_EQ(plain_text("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(plain_text("\xf4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(plain_text("\xf0\x9f"), "\uFFFD\uFFFD");
}

// A text within a line cannot start another line.
TEST(PlainText, LineHasNoLineEnd) { EXPECT_EQ(on_one_line("a\nb\tc\r\nd\re"), "a b c d\uFFFDe"); }

}  // namespace
}  // namespace turgor
