// Text as coverage: DejaVu Sans through FreeType when its file is on this machine, a coarse built-in font
// otherwise, so that a picture never lacks the letters that say which side is the patient's right.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// How much of each pixel a line of text covers; rows from the top.
struct TextMask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> coverage;  // width · height, 255 = all of it
  bool built_in = false;               // no font file was found
};

/// The file of the font; empty when there is none.
std::string font_file();

/// One line of UTF-8 text; `size` is the distance of two lines [pixels]. The font's file is the one named by
/// the environment variable TURGOR_FONT, or else DejaVuSans.ttf in the usual folders.
TextMask rasterize_text(std::string_view text, int size);

}  // namespace turgor
