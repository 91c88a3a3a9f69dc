// Annotations of pictures: text, color legends, captions over pictures in a row.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"

namespace turgor {

/// Rectangle of pixels; right and bottom are one past the last.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

enum class Align : std::uint8_t { kLeft, kCenter, kRight };

struct TextStyle {
  int size = 15;  // line height [pixels]
  Rgb color{236, 239, 242};
  Align align = Align::kLeft;
  bool halo = false;  // dark rim, for text over pictures
};

/// Draws a line of text with its left end, center or right end at x and its middle at height y. Only pixels
/// inside the returned box change.
PixelBox draw_text(Image& image, std::string_view text, int x, int y, const TextStyle& style = {});
/// Width of a line [pixels].
int text_width(std::string_view text, int size);

/// Draws a color bar with round numbers and the label at the right edge. The `slot`-th legend of a picture is
/// shifted left by `slot` columns. Returns the bar, whose top row has the color of `high`.
PixelBox draw_legend(Image& image, const ColorScale& scale, int slot = 0);

/// Fraction of a picture's width that a legend of normal width occupies.
constexpr double kLegendFraction = 0.22;

/// Draws a bar of round length with its label at the lower left. Its scale holds at the depth of the camera's
/// target, in the image plane. Returns the bar.
PixelBox draw_scale_bar(Image& image, const Camera& camera);

/// Row of a list of names: a color, and the things that are drawn in it.
struct NameRow {
  Rgb color;
  std::string names;  // "liver" or "gall bladder, stomach"
};
/// Adds a name to the row of its color, or a new row. A name that the row has already is not repeated.
void add_name(Rgb color, const std::string& name, std::vector<NameRow>& rows);
/// Draws the names beside their colors at the upper left. Returns the panel; empty without rows.
PixelBox draw_names(Image& image, const std::vector<NameRow>& rows);

/// Several pictures in a row, each with a caption above.
Image side_by_side(const std::vector<Image>& images, const std::vector<std::string>& captions);

}  // namespace turgor
