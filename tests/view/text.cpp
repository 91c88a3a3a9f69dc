#include "turgor/view/text.hpp"

#include <cstdlib>
#include <numeric>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Names a missing font file during its lifetime.
struct WithoutFont {
  WithoutFont() { setenv("TURGOR_FONT", "/no/such/font.ttf", 1); }
  ~WithoutFont() { unsetenv("TURGOR_FONT"); }
};

int ink(const TextMask& mask) { return std::accumulate(mask.coverage.begin(), mask.coverage.end(), 0) / 255; }

// Without a font file the built-in letters are used.
TEST(Text, FallsBackToBuiltInFont) {
  const WithoutFont without;
  for (const char* text : {"R", "L", "A", "P", "H", "F", "5 cm", "displacement [mm]"}) {
    const TextMask mask = rasterize_text(text, 20);
    EXPECT_TRUE(mask.built_in);
    EXPECT_GT(ink(mask), 10) << text;
  }
}

// Characters that the built-in font lacks are blank.
TEST(Text, UnknownCharactersAreBlank) {
  const WithoutFont without;
  EXPECT_EQ(ink(rasterize_text("µ°", 20)), 0);
  EXPECT_EQ(rasterize_text("µ°", 20).width, rasterize_text("ab", 20).width);
}

// Every letter has a different image.
TEST(Text, LettersAreDistinct) {
  const std::string letters = "RLAPHF0123456789";
  for (const char a : letters)
    for (const char b : letters)
      EXPECT_EQ(rasterize_text({&a, 1}, 24).coverage == rasterize_text({&b, 1}, 24).coverage, a == b)
          << a << b;
}

// Empty text and invalid UTF-8 do not crash.
TEST(Text, EmptyAndInvalidUtf8AreHarmless) {
  EXPECT_EQ(ink(rasterize_text("", 16)), 0);
  EXPECT_GE(rasterize_text("\xff\xfe\x80", 16).width, 0);
  EXPECT_GE(rasterize_text("a", 1).height, 1);
}

// A larger font size covers more pixels.
TEST(Text, LargerSizeCoversMore) {
  EXPECT_GT(ink(rasterize_text("stress", 40)), 2 * ink(rasterize_text("stress", 20)));
}

}  // namespace
}  // namespace turgor
