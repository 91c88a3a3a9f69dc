#include "turgor/io/files/xml_text.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Characters that would end a tag or an attribute are escaped.
TEST(XmlText, EscapesMarkup) {
  EXPECT_EQ(xml_text("<a b=\"c\" d='e'>&amp;"), "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;amp;");
}

// Characters of all languages are kept.
TEST(XmlText, KeepsUnicode) {
  const std::string text = "Kräfte [mm²], 力, 🫁\tand\n";
  EXPECT_EQ(xml_text(text), text);
}

// Control characters and invalid UTF-8 become the replacement character U+FFFD.
TEST(XmlText, InvalidBytesBecomeReplacementCharacter) {
  const std::string_view kUnknown = "\uFFFD";
  for (const std::string_view bad :
       {std::string_view("\0", 1), std::string_view("\x1b"), std::string_view("\x7f"), std::string_view("\r"),
        std::string_view("\xff"), std::string_view("\xc3"), std::string_view("\xc2\x9b")})
    EXPECT_TRUE(xml_text(bad).starts_with(kUnknown)) << testing::PrintToString(bad);
  EXPECT_EQ(xml_text("a\xe2\x82z"), "a\uFFFD\uFFFDz") << "an incomplete character";
  EXPECT_EQ(xml_text("\xc0\xbc").find('<'), std::string::npos) << "an overlong <";
  EXPECT_EQ(xml_text("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "half of a surrogate pair";
}

}  // namespace
}  // namespace turgor
