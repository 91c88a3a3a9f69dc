#include "turgor/window/camera_moves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace turgor {

namespace {

constexpr double kPole = 89.5 * std::numbers::pi / 180;  // [rad]

Vec3d plane_point(const Camera& camera, ScreenPosition position, double aspect) {
  return in_plane(camera, sight_ray(camera, position, aspect), camera.target);
}

Vec3d direction_of(StandardView view) {
  switch (view) {
    case StandardView::kFront:
      return {0, -1, 0};
    case StandardView::kBack:
      return {0, 1, 0};
    case StandardView::kRight:
      return {-1, 0, 0};
    case StandardView::kLeft:
      return {1, 0, 0};
    case StandardView::kHead:
      return {0, -0.01, 1};  // slightly from the front, which is then below
    case StandardView::kFeet:
      return {0, -0.01, -1};
  }
  return {0, -1, 0};
}

}  // namespace

Camera orbited(const Camera& camera, double right, double above) {
  const Vec3d up = normalized(camera.up), from = camera.eye - camera.target;
  const double distance = norm(from), height = dot(from, up);
  const CameraFrame frame = camera_frame(camera);
  Vec3d level = from - up * height;
  level = norm(level) > 1e-9 * distance ? normalized(level) : cross(frame.right, up);
  const Vec3d aside = cross(up, level);
  const double elevation =
      std::clamp(std::asin(std::clamp(height / distance, -1.0, 1.0)) + above, -kPole, kPole);
  const Vec3d turned = level * std::cos(right) + aside * std::sin(right);
  Camera moved = camera;
  moved.eye = camera.target + (turned * std::cos(elevation) + up * std::sin(elevation)) * distance;
  return moved;
}

Camera panned(const Camera& camera, ScreenPosition from, ScreenPosition to, double aspect) {
  const Vec3d shift = plane_point(camera, from, aspect) - plane_point(camera, to, aspect);
  Camera moved = camera;
  moved.eye += shift, moved.target += shift;
  return moved;
}

Camera zoomed(const Camera& camera, double factor, ScreenPosition position, double aspect) {
  const Vec3d stays = plane_point(camera, position, aspect);
  Camera moved = camera;
  moved.eye = stays + (camera.eye - stays) * factor;
  moved.target = stays + (camera.target - stays) * factor;
  return moved;
}

Camera focused(const Camera& camera, Vec3d point, double distance) {
  Camera moved = camera;
  moved.target = point, moved.eye = point + camera_frame(camera).back * distance;
  return moved;
}

Camera standard_view(StandardView view, const Box& box, double aspect) {
  return frame_box(box, direction_of(view), {0, 0, 1}, aspect);
}

SightRay sight_ray(const Camera& camera, ScreenPosition position, double aspect) {
  const CameraFrame frame = camera_frame(camera);
  const Vec3d direction = frame.right * (position.x * frame.tan_half * aspect) +
                          frame.up * (position.y * frame.tan_half) - frame.back;
  return {camera.eye, normalized(direction)};
}

std::optional<ScreenPosition> project(const Camera& camera, Vec3d point, double aspect) {
  const CameraFrame frame = camera_frame(camera);
  const Vec3d from_eye = point - camera.eye;
  const double depth = -dot(from_eye, frame.back);
  if (!(depth > 0)) return std::nullopt;
  return ScreenPosition{dot(from_eye, frame.right) / (depth * frame.tan_half * aspect),
                        dot(from_eye, frame.up) / (depth * frame.tan_half)};
}

Vec3d in_plane(const Camera& camera, const SightRay& ray, Vec3d point) {
  const Vec3d back = camera_frame(camera).back;
  return ray.from + ray.direction * (dot(point - ray.from, back) / dot(ray.direction, back));
}

}  // namespace turgor
