#include "turgor/view/projection.hpp"

#include <algorithm>

namespace turgor {

namespace {

struct Range {
  double low = 1e30, high = -1e30;
  double middle() const { return 0.5 * (low + high); }
  double length() const { return std::max(high - low, 1e-9); }
};

// Extent of the boxes along a direction.
Range extent(std::span<const Box> boxes, Vec3d direction) {
  Range range;
  for (const Box& box : boxes) {
    for (int i = 0; i < 8; i++) {
      const double along = dot(corner(box, i), direction);
      range = {std::min(range.low, along), std::max(range.high, along)};
    }
  }
  return boxes.empty() ? Range{0, 1} : range;
}

// Row `row` of the matrix: dot(direction, point) + offset.
void set_row(Mat4& m, std::size_t row, Vec3d direction, double offset) {
  for (int axis = 0; axis < 3; axis++) m[4 * std::size_t(axis) + row] = float(direction[axis]);
  m[12 + row] = float(offset);
}

}  // namespace

View make_view(std::span<const Box> boxes, const Camera& camera, double aspect) {
  View view{camera_frame(camera), camera.eye, aspect, 0, 0};
  const Range depths = extent(boxes, -view.frame.back);
  const double at_eye = dot(view.eye, -view.frame.back);
  view.far = depths.high > at_eye ? 1.01 * (depths.high - at_eye) : 1;
  view.near = std::clamp(0.98 * (depths.low - at_eye), 2e-3 * view.far, 0.9 * view.far);
  return view;
}

Mat4 camera_matrix(const View& view) {
  const auto& [right, up, back, tan_half] = view.frame;
  const double sx = 1 / (tan_half * view.aspect), sy = 1 / tan_half, length = view.near - view.far;
  const double a = (view.near + view.far) / length, b = 2 * view.near * view.far / length;
  Mat4 m{};
  set_row(m, 0, right * sx, -sx * dot(right, view.eye));
  set_row(m, 1, up * sy, -sy * dot(up, view.eye));
  set_row(m, 2, back * a, -a * dot(back, view.eye) + b);
  set_row(m, 3, -back, dot(back, view.eye));
  return m;
}

LightView make_light_view(std::span<const Box> boxes, Vec3d towards_light) {
  const CameraFrame frame = camera_frame({.eye = towards_light, .target = {}, .up = {0, 0, 1}});
  const Range x = extent(boxes, frame.right), y = extent(boxes, frame.up), z = extent(boxes, -frame.back);
  const double width = std::max(x.length(), y.length());
  Mat4 m{};
  set_row(m, 0, frame.right * (2 / width), -2 * x.middle() / width);
  set_row(m, 1, frame.up * (2 / width), -2 * y.middle() / width);
  set_row(m, 2, -frame.back * (2 / z.length()), -2 * z.middle() / z.length());
  m[15] = 1;
  return {m, width};
}

}  // namespace turgor
