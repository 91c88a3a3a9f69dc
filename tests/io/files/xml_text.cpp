#include "turgor/io/files/xml_text.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(XmlText, NothingInItEndsATagOrAnAttribute) {
  EXPECT_EQ(xml_text("<a b=\"c\" d='e'>&amp;"), "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;amp;");
}

TEST(XmlText, CharactersOfAllLanguagesStay) {
  const std::string text = "Kräfte [mm²], 力, 🫁\tand\n";
  EXPECT_EQ(xml_text(text), text);
}

TEST(XmlText, ControlCharactersAndBrokenBytesBecomeTheUnknownCharacter) {
  const std::string_view kUnknown = "\uFFFD";
  for (const std::string_view bad :
       {std::string_view("\0", 1), std::string_view("\x1b"), std::string_view("\x7f"), std::string_view("\r"),
        std::string_view("\xff"), std::string_view("\xc3"), std::string_view("\xc2\x9b")})
    EXPECT_TRUE(xml_text(bad).starts_with(kUnknown)) << testing::PrintToString(bad);
  EXPECT_EQ(xml_text("a\xe2\x82z"), "a\uFFFD\uFFFDz") << "a character that stops half way";
  EXPECT_EQ(xml_text("\xc0\xbc").find('<'), std::string::npos) << "an overlong <";
  EXPECT_EQ(xml_text("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "half of a pair";
}

}  // namespace
}  // namespace turgor
