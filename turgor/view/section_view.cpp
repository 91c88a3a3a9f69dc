#include "turgor/view/section_view.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/view/annotate.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/sample.hpp"

namespace turgor {

namespace {

constexpr double kMostAspect = 3;  // limits the height of a thin stack of slices

struct NamedWindow {
  const char* name;
  Window window;
};
// Common windows of CT workstations.
constexpr NamedWindow kWindows[] = {{"abdomen", {350, 40}},
                                    {"bone", {1800, 400}},
                                    {"lung", {1500, -600}},
                                    {"brain", {80, 40}},
                                    {"air", {1000, -430}}};

struct PlaneAxes {
  Vec3d right, down;
  const char *left_letter, *right_letter, *top_letter, *bottom_letter;
};
// LPS: +x is the patient's left, +y the back (posterior), +z the head.
PlaneAxes plane_axes(Plane plane) {
  switch (plane) {
    case Plane::kAxial:
      return {{1, 0, 0}, {0, 1, 0}, "R", "L", "A", "P"};
    case Plane::kCoronal:
      return {{1, 0, 0}, {0, 0, -1}, "R", "L", "H", "F"};
    case Plane::kSagittal:
      return {{0, 1, 0}, {0, 0, -1}, "A", "P", "H", "F"};
  }
  return {};
}

Image resample(const CtVolume& ct, const SectionFrame& frame, Window window) {
  Image image = make_image(frame.width, frame.height);
  const Vec3d first = index_at(ct.grid, frame.corner);
  const Vec3d along = index_at(ct.grid, frame.corner + frame.right * frame.pixel) - first;
  const Vec3d below = index_at(ct.grid, frame.corner + frame.down * frame.pixel) - first;
  for (int y = 0; y < frame.height; y++) {
    for (int x = 0; x < frame.width; x++) {
      const Vec3d index = first + along * double(x) + below * double(y);
      if (!inside_samples(ct.grid, index)) continue;
      const std::uint8_t g = gray_value(sample_clamped(ct, Vec3(index)), window);
      image.at(x, y) = {g, g, g};
    }
  }
  return image;
}

void draw_letters(Image& image, const PlaneAxes& axes) {
  const int size = std::clamp(image.height / 22, 12, 40), edge = size * 3 / 4;
  const TextStyle style{.size = size, .color = {255, 214, 120}, .align = Align::kCenter, .halo = true};
  draw_text(image, axes.left_letter, edge, image.height / 2, style);
  draw_text(image, axes.right_letter, image.width - edge, image.height / 2, style);
  draw_text(image, axes.top_letter, image.width / 2, edge, style);
  draw_text(image, axes.bottom_letter, image.width / 2, image.height - edge, style);
}

// Longest round length that fits a quarter of the picture.
double bar_length(double picture_width) {
  double best = 0.001;
  for (const double mm : {1, 2, 5, 10, 20, 50, 100, 200})
    if (mm * 0.001 <= picture_width / 4) best = mm * 0.001;
  return best;
}

void draw_scale_bar(Image& image, double pixel) {
  const double length = bar_length(pixel * image.width);
  const int pixels = int(std::lround(length / pixel)), size = std::clamp(image.height / 32, 11, 28);
  const int left = size, y = image.height - size, thick = std::max(2, size / 6);
  const auto fill = [&image](int x0, int y0, int x1, int y1, Rgb color) {
    for (int v = std::max(0, y0); v < std::min(image.height, y1); v++)
      for (int u = std::max(0, x0); u < std::min(image.width, x1); u++) image.at(u, v) = color;
  };
  fill(left - 1, y - thick - 1, left + pixels + 1, y + 1, {});
  fill(left, y - thick, left + pixels, y, {236, 239, 242});
  const std::string text =
      length < 0.01 ? fmt::format("{:.0f} mm", 1e3 * length) : fmt::format("{:.0f} cm", 1e2 * length);
  draw_text(image, text, left, y - thick - size * 2 / 3, {.size = size, .halo = true});
}

}  // namespace

std::uint8_t gray_value(double hu, Window window) {
  const double fraction = (hu - window.level) / std::max(window.width, 1e-9) + 0.5;
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(fraction, 0.0, 1.0)));
}

Result<Window> window_preset(const std::string& name) {
  std::string known;
  for (const NamedWindow& preset : kWindows) {
    if (preset.name == name) return preset.window;
    known += fmt::format("{}\"{}\"", known.empty() ? "" : ", ", preset.name);
  }
  return Error{fmt::format("unknown window \"{}\": expected one of {}", name, known)};
}

SectionFrame section_frame(const Grid& grid, Plane plane, Vec3d point, int height) {
  const Box box = bounding_box(grid);
  const PlaneAxes axes = plane_axes(plane);
  const Vec3d extent = box.high - box.low, middle = (box.low + box.high) * 0.5;
  const double wide = std::abs(dot(extent, axes.right)), tall = std::abs(dot(extent, axes.down));
  const double aspect = std::clamp(wide / tall, 1 / kMostAspect, kMostAspect);

  SectionFrame frame{.right = axes.right, .down = axes.down, .height = std::max(height, 1)};
  frame.width = std::max(1, int(std::lround(aspect * frame.height)));
  frame.pixel = std::max(tall / frame.height, wide / frame.width);
  const Vec3d normal = cross(axes.right, axes.down);
  const Vec3d center = middle + normal * dot(point - middle, normal);
  frame.corner = center - (frame.right * double(frame.width - 1) + frame.down * double(frame.height - 1)) *
                              (frame.pixel / 2);
  return frame;
}

Image draw_section(const CtVolume& ct, Plane plane, Vec3d point, Window window, int height) {
  const SectionFrame frame = section_frame(ct.grid, plane, point, height);
  Image image = resample(ct, frame, window);
  draw_letters(image, plane_axes(plane));
  draw_scale_bar(image, frame.pixel);
  return image;
}

}  // namespace turgor
