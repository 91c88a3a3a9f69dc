#include "turgor/view/annotate.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/round_ticks.hpp"
#include "turgor/view/text.hpp"

namespace turgor {

namespace {

constexpr Rgb kInk{236, 239, 242}, kPanel{16, 20, 26};
constexpr int kHalo = 2;  // [pixels]

void blend(Image& image, int x, int y, Rgb color, float fraction) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  image.at(x, y) = mix(image.at(x, y), color, fraction);
}

void fill(Image& image, const PixelBox& box, Rgb color, float opacity) {
  for (int y = box.top; y < box.bottom; y++)
    for (int x = box.left; x < box.right; x++) blend(image, x, y, color, opacity);
}

int coverage_near(const TextMask& mask, int x, int y, int reach) {
  int most = 0;
  for (int v = std::max(0, y - reach); v <= std::min(mask.height - 1, y + reach); v++)
    for (int u = std::max(0, x - reach); u <= std::min(mask.width - 1, x + reach); u++)
      if ((u - x) * (u - x) + (v - y) * (v - y) <= reach * reach)
        most = std::max(most, int(mask.coverage[std::size_t(v * mask.width + u)]));
  return most;
}

std::string tick_text(double value, double step) {
  const int decimals = std::clamp(int(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return step >= 1e6 || step < 1e-6 ? fmt::format("{:.3g}", value) : fmt::format("{:.{}f}", value, decimals);
}

struct Tick {
  float fraction;
  std::string text;
};

std::vector<Tick> legend_ticks(const ColorScale& scale, int count) {
  const double a = double(scale.low) * scale.factor, b = double(scale.high) * scale.factor;
  const std::vector<double> values = round_ticks(std::min(a, b), std::max(a, b), count);
  std::vector<Tick> ticks;
  for (const double value : values) {
    const double step = values.size() > 1 ? values[1] - values[0] : std::max(std::abs(value), 1.0);
    ticks.push_back({float((value - a) / (b - a)), tick_text(value, step)});
  }
  return ticks;
}

// Largest size up to `size` at which the text fits into the width; never illegibly small.
int fitting_size(std::string_view text, int size, int max_width) {
  while (size > 9 && text_width(text, size) > max_width) size--;
  return size;
}

}  // namespace

PixelBox draw_text(Image& image, std::string_view text, int x, int y, const TextStyle& style) {
  const TextMask mask = rasterize_text(text, style.size);
  const int rim = style.halo ? kHalo : 0;
  const int shift = style.align == Align::kLeft     ? 0
                    : style.align == Align::kCenter ? mask.width / 2
                                                    : mask.width;
  const int left = x - shift, top = y - mask.height / 2;
  for (int v = -rim; v < mask.height + rim; v++) {
    for (int u = -rim; u < mask.width + rim; u++) {
      if (rim) blend(image, left + u, top + v, {}, 0.7f * float(coverage_near(mask, u, v, rim)) / 255);
      blend(image, left + u, top + v, style.color, float(coverage_near(mask, u, v, 0)) / 255);
    }
  }
  return {left - rim, top - rim, left + mask.width + rim, top + mask.height + rim};
}

int text_width(std::string_view text, int size) { return rasterize_text(text, size).width; }

PixelBox draw_legend(Image& image, const ColorScale& scale, int slot) {
  const int size = std::clamp(image.height / 40, 11, 40), bar_width = size, bar_height = image.height / 2;
  const std::vector<Tick> ticks = legend_ticks(scale, 6);
  int numbers = 0;
  for (const Tick& tick : ticks) numbers = std::max(numbers, text_width(tick.text, size));
  const int content = std::max(bar_width + size / 2 + numbers, text_width(scale.label, size));
  const int right = image.width - size - slot * (content + 3 * size), left = right - content;
  const PixelBox bar{left, (image.height - bar_height) / 2, left + bar_width,
                     (image.height + bar_height) / 2};

  fill(image, {left - size, bar.top - 3 * size, right + size, bar.bottom + size}, kPanel, 0.55f);
  draw_text(image, scale.label, left, bar.top - 3 * size / 2, {.size = size, .color = kInk});
  for (int y = bar.top; y < bar.bottom; y++)
    fill(image, {bar.left, y, bar.right, y + 1}, map_color(float(bar.bottom - 1 - y) / float(bar_height - 1)),
         1);
  for (const Tick& tick : ticks) {
    const int y = bar.bottom - 1 - int(std::lround(tick.fraction * float(bar_height - 1)));
    fill(image, {bar.right, y, bar.right + size / 4, y + 1}, kInk, 1);
    draw_text(image, tick.text, bar.right + size / 2, y, {.size = size, .color = kInk});
  }
  return bar;
}

PixelBox draw_scale_bar(Image& image, const Camera& camera) {
  const int size = std::clamp(image.height / 32, 11, 40), margin = size;
  const double height =
      2 * norm(camera.eye - camera.target) * camera_frame(camera).tan_half;  // of the picture [m]
  const double longest = 0.2 * height * image.width / image.height;
  double length = std::pow(10, std::floor(std::log10(longest)));
  for (const double more : {5.0, 2.0})
    if (more * length <= longest) {
      length *= more;
      break;
    }
  const int pixels = int(std::lround(length / height * image.height)), bottom = image.height - margin;
  const PixelBox bar{margin, bottom - std::max(2, size / 5), margin + pixels, bottom};
  const std::string text =
      length >= 0.999 ? fmt::format("{:.0f} m", length) : fmt::format("{:.3g} mm", 1e3 * length);
  const int right = std::max(bar.right, bar.left + text_width(text, size)), pad = size / 2;
  fill(image, {bar.left - pad, bar.top - 3 * size / 2 - pad, right + pad, bar.bottom + pad}, kPanel, 0.6f);
  fill(image, bar, kInk, 1);
  draw_text(image, text, bar.left, bar.top - 5 * size / 6, {.size = size, .color = kInk});
  return bar;
}

void add_name(Rgb color, const std::string& name, std::vector<NameRow>& rows) {
  for (NameRow& row : rows) {
    if (!(row.color == color)) continue;
    const std::string known = ", " + row.names + ",";
    if (known.find(" " + name + ",") == std::string::npos) row.names += ", " + name;
    return;
  }
  rows.push_back({color, name});
}

PixelBox draw_names(Image& image, const std::vector<NameRow>& rows) {
  if (rows.empty()) return {};
  // long names are cut where they would cover more than half of the picture
  const int size = std::clamp(image.height / 36, 11, 40), pad = size / 2, line = 3 * size / 2;
  const int widest = image.width / 2 - 3 * size;
  std::vector<std::string> names;
  int width = 0;
  for (const NameRow& row : rows) {
    std::string name = row.names;
    while (name.size() > 4 && text_width(name, size) > widest) name.resize(name.size() - 4), name += "...";
    width = std::max(width, text_width(name, size));
    names.push_back(std::move(name));
  }
  // panel, swatches and names
  const PixelBox panel{pad, pad, 4 * pad + size + width, 2 * pad + int(rows.size()) * line};
  fill(image, panel, kPanel, 0.6f);
  for (std::size_t n = 0; n < rows.size(); n++) {
    const int middle = panel.top + pad / 2 + int(n) * line + line / 2, half = size / 2;
    fill(image, {2 * pad, middle - half, 2 * pad + 2 * half, middle + half}, rows[n].color, 1);
    draw_text(image, names[n], 3 * pad + size, middle, {.size = size, .color = kInk});
  }
  return panel;
}

Image side_by_side(const std::vector<Image>& images, const std::vector<std::string>& captions) {
  constexpr int kGap = 4;
  int width = 0, height = 0;
  for (const Image& image : images) {
    width += image.width + (width > 0 ? kGap : 0);
    height = std::max(height, image.height);
  }
  const int size = std::clamp(height / 28, 12, 48), band = captions.empty() ? 0 : 2 * size;
  Image row = make_image(width, height + band, kPanel);
  int left = 0;
  for (std::size_t i = 0; i < images.size(); i++) {
    const Image& image = images[i];
    for (int y = 0; y < image.height; y++)
      std::copy_n(&image.pixels[std::size_t(y) * std::size_t(image.width)], image.width,
                  &row.at(left, band + y));
    if (i < captions.size())
      draw_text(
          row, captions[i], left + image.width / 2, band / 2,
          {.size = fitting_size(captions[i], size, image.width), .color = kInk, .align = Align::kCenter});
    left += image.width + kGap;
  }
  return row;
}

}  // namespace turgor
