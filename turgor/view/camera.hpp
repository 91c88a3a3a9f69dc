// Perspective camera that looks from its eye at its target. Patient frame LPS, meters.
#pragma once

#include "turgor/geometry/box.hpp"
#include "turgor/geometry/grid.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct Camera {
  Vec3d eye, target, up{0, 0, 1};  // [m], [m], any length
  double field_of_view = 30;       // vertical [degrees]
};

/// Axes of the camera: a point at depth d along -back is visible within d · tan_half of the center, up and
/// down.
struct CameraFrame {
  Vec3d right, up, back;  // unit, right-handed
  double tan_half;
};
/// An `up` parallel to the line of sight is replaced.
CameraFrame camera_frame(const Camera& camera);

/// Corner 0…7: bit 0 chooses the high x, bit 1 the high y, bit 2 the high z.
constexpr Vec3d corner(const Box& box, int index) {
  return {index & 1 ? box.high.x : box.low.x, index & 2 ? box.high.y : box.low.y,
          index & 4 ? box.high.z : box.low.z};
}
/// Zero box for a mesh without vertices.
Box bounding_box(const TriMesh& mesh);
/// Whole samples: half a spacing beyond the outermost sample positions.
Box bounding_box(const Grid& grid);

/// Camera that shows the whole box from `direction` (from the box towards the eye), in pictures of this width
/// / height.
Camera frame_box(const Box& box, Vec3d direction, Vec3d up, double aspect);

/// The camera moved back and sideways, so that its former picture leaves this fraction of the width free on
/// the right.
Camera with_margin_right(const Camera& camera, double aspect, double fraction);

}  // namespace turgor
