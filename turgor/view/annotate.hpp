// What is written onto pictures: text, a legend of colours, captions over several pictures in a row.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"

namespace turgor {

/// A rectangle of pixels; right and bottom are one past the last.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

enum class Align : std::uint8_t { kLeft, kCenter, kRight };

struct TextStyle {
  int size = 15;  // distance of two lines [pixels]
  Rgb color{236, 239, 242};
  Align align = Align::kLeft;
  bool halo = false;  // a dark rim, for text over pictures
};

/// Writes a line whose left end, centre or right end is at x and whose middle is at height y. Only pixels
/// inside the returned box change.
PixelBox draw_text(Image& image, std::string_view text, int x, int y, const TextStyle& style = {});
/// Pixels from the left to the right end of a line.
int text_width(std::string_view text, int size);

/// A bar of the scale's colours with round numbers and the label, at the right edge; the `slot`-th legend of
/// a picture stands `slot` places to the left. Returns the bar, whose top row is the colour of `high`.
PixelBox draw_legend(Image& image, const ColorScale& scale, int slot = 0);

/// The part of a picture's width that a legend takes, with one that is not wide.
constexpr double kLegendPart = 0.22;

/// A bar of a round length, with its length, at the lower left: it is as long as what lies at the camera's
/// target and faces it. Returns the bar.
PixelBox draw_scale_bar(Image& image, const Camera& camera);

/// Several pictures in a row, each with a caption above.
Image side_by_side(const std::vector<Image>& images, const std::vector<std::string>& captions);

}  // namespace turgor
