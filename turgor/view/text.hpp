// Text as coverage: DejaVu Sans through FreeType if its file exists on this machine, else a coarse built-in
// font. Orientation letters therefore never depend on installed fonts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// Pixel coverage of a line of text; rows from the top.
struct TextMask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> coverage;  // width · height, 255 = fully covered
  bool built_in = false;               // no font file was found
};

/// Path of the font, or empty.
std::string font_file();

/// One line of UTF-8 text; `size` is the line height [pixels]. The font is the file named by the environment
/// variable TURGOR_FONT, or else DejaVuSans.ttf in the usual folders.
TextMask rasterize_text(std::string_view text, int size);

}  // namespace turgor
