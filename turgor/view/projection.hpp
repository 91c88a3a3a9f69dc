// Projections from patient space to OpenGL clip space: for the camera, and for a light that covers the whole
// scene.
#pragma once

#include <array>
#include <span>

#include "turgor/view/camera.hpp"

namespace turgor {

/// A 4×4 matrix by columns.
using Mat4 = std::array<float, 16>;

/// A camera with its near and far planes [m].
struct View {
  CameraFrame frame;
  Vec3d eye;
  double aspect, near, far;
};
/// Near and far planes enclose the boxes.
View make_view(std::span<const Box> boxes, const Camera& camera, double aspect);
Mat4 camera_matrix(const View& view);

/// Parallel projection of all boxes along the light.
struct LightView {
  Mat4 matrix;
  double width;  // extent of the projection, the larger of the two directions [m]
};
LightView make_light_view(std::span<const Box> boxes, Vec3d towards_light);

}  // namespace turgor
