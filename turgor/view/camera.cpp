#include "turgor/view/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace turgor {

namespace {

constexpr double kFrameMargin = 1.04;  // margin around the box of frame_box

}  // namespace

CameraFrame camera_frame(const Camera& camera) {
  Vec3d back = normalized(camera.eye - camera.target);
  if (norm(back) == 0) back = {0, -1, 0};
  Vec3d right = cross(normalized(camera.up), back);
  if (norm(right) < 1e-6) right = cross(std::abs(back.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0}, back);
  right = normalized(right);
  return {right, cross(back, right), back, std::tan(camera.field_of_view * std::numbers::pi / 360)};
}

Box bounding_box(const TriMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3 x : mesh.vertices) low = min(low, x), high = max(high, x);
  return {Vec3d(low), Vec3d(high)};
}

Box bounding_box(const Grid& grid) {
  const Box indices{{-0.5, -0.5, -0.5}, Vec3d(grid.size) - Vec3d{0.5, 0.5, 0.5}};
  Box box{point_at(grid, indices.low), point_at(grid, indices.low)};
  for (int i = 1; i < 8; i++) {
    const Vec3d x = point_at(grid, corner(indices, i));
    box = {min(box.low, x), max(box.high, x)};
  }
  return box;
}

Camera frame_box(const Box& box, Vec3d direction, Vec3d up, double aspect) {
  const Vec3d center = (box.low + box.high) * 0.5;
  Camera camera{.eye = center + direction, .target = center, .up = up};
  const CameraFrame frame = camera_frame(camera);
  double distance = 0;
  for (int i = 0; i < 8; i++) {
    const Vec3d x = corner(box, i) - center;
    const double wide = std::abs(dot(x, frame.right)) / aspect, tall = std::abs(dot(x, frame.up));
    distance = std::max(distance, dot(x, frame.back) + kFrameMargin * std::max(wide, tall) / frame.tan_half);
  }
  camera.eye = center + frame.back * (distance > 0 ? distance : 1.0);
  return camera;
}

Camera with_margin_right(const Camera& camera, double aspect, double fraction) {
  const CameraFrame frame = camera_frame(camera);
  const double distance = norm(camera.eye - camera.target) / (1 - fraction);
  Camera moved = camera;
  const Vec3d aside = frame.right * (fraction * distance * frame.tan_half * aspect);
  moved.target += aside;
  moved.eye = moved.target + frame.back * distance;
  return moved;
}

}  // namespace turgor
