// How a camera goes where a person with a mouse wants it: pure functions from one camera to the next. Places
// in the picture are Seen: x from -1 (left) to 1 (right), y from -1 (below) to 1 (above).
#pragma once

#include <cstdint>
#include <optional>

#include "turgor/view/camera.hpp"

namespace turgor {

struct Seen {
  double x = 0, y = 0;
};

/// Around its target: to the right about `up`, and up, never beyond the poles [rad].
Camera orbited(const Camera& camera, double right, double above);
/// So that what was seen at `from` at the target's depth is seen at `to`.
Camera panned(const Camera& camera, Seen from, Seen to, double aspect);
/// Everything comes nearer by a factor below 1, and what is seen at a place, at the target's depth, stays
/// there.
Camera zoomed(const Camera& camera, double factor, Seen place, double aspect);
/// Turns about a point, at a distance [m].
Camera focused(const Camera& camera, Vec3d point, double distance);

/// As radiologists and surgeons name them: from there, with the head or the front up.
enum class StandardView : std::uint8_t { kFront, kBack, kRight, kLeft, kHead, kFeet };
Camera standard_view(StandardView view, const Box& box, double aspect);

/// From the eye through a place of the picture.
struct SightRay {
  Vec3d from, direction;  // [m], unit
};
SightRay sight_ray(const Camera& camera, Seen place, double aspect);
/// Where a point is seen; none behind the eye.
std::optional<Seen> seen_at(const Camera& camera, Vec3d point, double aspect);
/// The point of a ray in the plane through `point` that the camera looks at squarely.
Vec3d in_plane(const Camera& camera, const SightRay& ray, Vec3d point);

}  // namespace turgor
