// Camera navigation with a mouse: pure functions from one camera to the next. Picture coordinates are
// ScreenPosition: x from -1 (left) to 1 (right), y from -1 (bottom) to 1 (top).
#pragma once

#include <cstdint>
#include <optional>

#include "turgor/view/camera.hpp"

namespace turgor {

struct ScreenPosition {
  double x = 0, y = 0;
};

/// Orbits around the target: right about `up`, and up, never beyond the poles [rad].
Camera orbited(const Camera& camera, double right, double above);
/// Moves the point seen at `from`, at the target's depth, to `to`.
Camera panned(const Camera& camera, ScreenPosition from, ScreenPosition to, double aspect);
/// Scales all distances by `factor`; the point seen at `position`, at the target's depth, stays fixed.
Camera zoomed(const Camera& camera, double factor, ScreenPosition position, double aspect);
/// Turns about a point, at a distance [m].
Camera focused(const Camera& camera, Vec3d point, double distance);

/// Standard views of radiology and surgery, with the head or the front up.
enum class StandardView : std::uint8_t { kFront, kBack, kRight, kLeft, kHead, kFeet };
Camera standard_view(StandardView view, const Box& box, double aspect);

/// Ray from the eye through a picture position.
struct SightRay {
  Vec3d from, direction;  // [m], unit
};
SightRay sight_ray(const Camera& camera, ScreenPosition position, double aspect);
/// Picture position of a point; empty behind the eye.
std::optional<ScreenPosition> project(const Camera& camera, Vec3d point, double aspect);
/// Intersection of a ray with the plane through `point` perpendicular to the view direction.
Vec3d in_plane(const Camera& camera, const SightRay& ray, Vec3d point);

}  // namespace turgor
