// From patient space to what OpenGL clips and draws: for the camera, and for a light that sees the whole
// scene.
#pragma once

#include <array>
#include <span>

#include "turgor/view/camera.hpp"

namespace turgor {

/// A 4×4 matrix by columns.
using Mat4 = std::array<float, 16>;

/// A camera together with the nearest and farthest depth that it shows [m].
struct View {
  CameraFrame frame;
  Vec3d eye;
  double aspect, near, far;
};
/// Near and far are taken from what there is to see.
View make_view(std::span<const Box> boxes, const Camera& camera, double aspect);
Mat4 camera_matrix(const View& view);

/// A parallel projection of everything in the boxes, seen against the light.
struct LightView {
  Mat4 matrix;
  double width;  // of what it sees, the larger of the two directions [m]
};
LightView make_light_view(std::span<const Box> boxes, Vec3d towards_light);

}  // namespace turgor
