#include "turgor/view/text.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include <ft2build.h>
#include FT_FREETYPE_H

#include "turgor/io/files/shipped_file.hpp"
#include "turgor/view/built_in_font.hpp"

namespace turgor {

namespace {

using Library = std::unique_ptr<FT_LibraryRec_, decltype(&FT_Done_FreeType)>;
using Face = std::unique_ptr<FT_FaceRec_, decltype(&FT_Done_Face)>;

}  // namespace

std::string font_file() {
  if (const char* chosen = std::getenv("TURGOR_FONT")) return chosen;
  return shipped_file(
      "DejaVuSans.ttf",
      {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
       "/usr/share/fonts/TTF/DejaVuSans.ttf", "/usr/share/fonts/dejavu/DejaVuSans.ttf",
       "/usr/local/share/fonts/DejaVuSans.ttf"});
}

namespace {

std::vector<char32_t> code_points(std::string_view text) {
  std::vector<char32_t> points;
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if ((byte & 0xC0) != 0x80)
      points.push_back(byte < 0x80   ? byte
                       : byte < 0xE0 ? byte & 0x1F
                       : byte < 0xF0 ? byte & 0x0F
                                     : byte & 0x07);
    else if (!points.empty())
      points.back() = points.back() << 6 | (byte & 0x3F);
  }
  return points;
}

// Grows the mask to the right and adds the glyph's bitmap.
void add_bitmap(const FT_Bitmap& bitmap, int left, int top, TextMask& mask) {
  for (int y = 0; y < int(bitmap.rows); y++) {
    for (int x = 0; x < int(bitmap.width); x++) {
      const int column = left + x, row = top + y;
      if (column < 0 || column >= mask.width || row < 0 || row >= mask.height) continue;
      auto& pixel = mask.coverage[std::size_t(row * mask.width + column)];
      pixel = std::max(pixel, bitmap.buffer[y * bitmap.pitch + x]);
    }
  }
}

// False if a glyph does not load; FreeType's own units are 1/64 pixel.
bool rasterize(FT_Face face, std::string_view text, int size, TextMask& mask) {
  const std::vector<char32_t> points = code_points(text);
  const int baseline = int((face->size->metrics.ascender + 32) / 64);
  FT_Pos pen = 64;
  for (const char32_t point : points) {
    if (FT_Load_Char(face, point, FT_LOAD_DEFAULT)) return false;
    pen += face->glyph->advance.x;
  }
  mask = {int(pen / 64) + 2, std::max(size, int((face->size->metrics.height + 63) / 64)), {}, false};
  mask.coverage.resize(std::size_t(mask.width) * std::size_t(mask.height));
  pen = 64;
  for (const char32_t point : points) {
    if (FT_Load_Char(face, point, FT_LOAD_RENDER)) return false;
    if (face->glyph->bitmap.pixel_mode != FT_PIXEL_MODE_GRAY)
      return false;  // bitmap font, eight dots per byte
    add_bitmap(face->glyph->bitmap, int(pen / 64) + face->glyph->bitmap_left,
               baseline - face->glyph->bitmap_top, mask);
    pen += face->glyph->advance.x;
  }
  return true;
}

bool rasterize_with_font(std::string_view text, int size, TextMask& mask) {
  const std::string file = font_file();
  if (file.empty()) return false;
  FT_Library raw_library = nullptr;
  if (FT_Init_FreeType(&raw_library)) return false;
  const Library library(raw_library, FT_Done_FreeType);
  FT_Face raw_face = nullptr;
  if (FT_New_Face(library.get(), file.c_str(), 0, &raw_face)) return false;
  const Face face(raw_face, FT_Done_Face);
  // DejaVu's line height is 1.17 times its letter size.
  if (FT_Set_Pixel_Sizes(face.get(), 0, FT_UInt(std::max(1, size * 6 / 7)))) return false;
  return rasterize(face.get(), text, size, mask);
}

const DotGlyph* find_glyph(char32_t point) {
  if (point > 127) return nullptr;
  const char letter = char(std::toupper(int(point)));
  for (const DotGlyph& glyph : kDotGlyphs)
    if (glyph.letter == letter) return &glyph;
  return nullptr;
}

TextMask rasterize_built_in(std::string_view text, int size) {
  const std::vector<char32_t> points = code_points(text);
  const int dot = std::max(1, size / 10), width = int(points.size()) * 6 * dot + dot,
            height = std::max(size, 7 * dot);
  TextMask mask{width, height, std::vector<std::uint8_t>(std::size_t(width) * std::size_t(height)), true};
  const int top = (height - 7 * dot) / 2;
  for (int i = 0; i < int(points.size()); i++) {
    const DotGlyph* glyph = find_glyph(points[std::size_t(i)]);
    for (int y = 0; glyph && y < 7 * dot; y++)
      for (int x = 0; x < 5 * dot; x++)
        if (glyph->rows[y / dot] >> (4 - x / dot) & 1)
          mask.coverage[std::size_t((top + y) * width + dot + i * 6 * dot + x)] = 255;
  }
  return mask;
}

}  // namespace

TextMask rasterize_text(std::string_view text, int size) {
  TextMask mask;
  if (rasterize_with_font(text, size, mask)) return mask;
  return rasterize_built_in(text, size);
}

}  // namespace turgor
