// Test shapes for pictures: spheres as meshes, balls and boxes as CTs, and functions that find them in a
// picture.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "turgor/view/draw.hpp"

namespace turgor::test {

inline TriMesh sphere(Vec3 center, float radius, int rings = 48) {
  TriMesh mesh;
  const int columns = 2 * rings;
  for (int j = 0; j <= rings; j++) {
    for (int i = 0; i < columns; i++) {
      const float polar = std::numbers::pi_v<float> * float(j) / float(rings);
      const float turn = std::numbers::pi_v<float> * float(i) / float(rings);
      mesh.vertices.push_back(
          center +
          Vec3{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)} * radius);
    }
  }
  for (int j = 0; j < rings; j++) {
    for (int i = 0; i < columns; i++) {
      const int a = j * columns + i, b = j * columns + (i + 1) % columns;
      mesh.triangles.push_back({a, a + columns, b});
      mesh.triangles.push_back({b, a + columns, b + columns});
    }
  }
  return mesh;
}

/// Axes rotated by 30° about z and by 20° about x, with the first one flipped.
inline Mat3d oblique_axes() {
  const double a = std::numbers::pi / 6, b = std::numbers::pi / 9;
  const Mat3d about_z{{{std::cos(a), std::sin(a), 0}, {-std::sin(a), std::cos(a), 0}, {0, 0, 1}}};
  const Mat3d about_x{{{1, 0, 0}, {0, std::cos(b), std::sin(b)}, {0, -std::sin(b), std::cos(b)}}};
  Mat3d axes = about_x * about_z;
  axes.column[0] = -axes.column[0];
  return axes;
}

/// A grid centered at `center`.
inline Grid centered_grid(Int3 size, Vec3d spacing, Vec3d center, const Mat3d& axes = {}) {
  Grid grid{.size = size, .spacing = spacing, .origin = {}, .axes = axes};
  grid.origin = center - point_at(grid, (Vec3d(size) - Vec3d{1, 1, 1}) * 0.5);
  return grid;
}

inline CtVolume fill_volume(const Grid& grid, const std::function<double(Vec3d)>& hu_at) {
  CtVolume ct{grid, std::vector<std::int16_t>(sample_count(grid))};
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++)
        ct.at(i, j, k) = std::int16_t(std::lround(hu_at(point_at(grid, Vec3d(Int3{i, j, k})))));
  return ct;
}

/// A ball of tissue in air. Its border fades over one sample, like partial volumes.
inline CtVolume ball_volume(const Grid& grid, Vec3d center, double radius, double hu) {
  const double fade = std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  return fill_volume(grid, [=](Vec3d x) {
    const double inside = std::clamp((radius - norm(x - center)) / fade + 0.5, 0.0, 1.0);
    return kAirHu + inside * (hu - kAirHu);
  });
}

struct Found {
  int count = 0;
  double x = 0, y = 0;  // centroid [pixels]
};
inline Found find_pixels(const Image& image, const std::function<bool(int, int)>& is_wanted) {
  Found found;
  for (int y = 0; y < image.height; y++) {
    for (int x = 0; x < image.width; x++) {
      if (!is_wanted(x, y)) continue;
      found.count++;
      found.x += x + 0.5;
      found.y += y + 0.5;
    }
  }
  if (found.count > 0) found.x /= found.count, found.y /= found.count;
  return found;
}

inline int difference(Rgb a, Rgb b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
}

/// Projection of a point [pixels].
inline Vec3d project(const Camera& camera, Vec3d point, int width, int height) {
  const CameraFrame frame = camera_frame(camera);
  const Vec3d from_eye = point - camera.eye;
  const double depth = -dot(from_eye, frame.back), scale = 0.5 * height / (frame.tan_half * depth);
  return {0.5 * width + scale * dot(from_eye, frame.right), 0.5 * height - scale * dot(from_eye, frame.up),
          depth};
}

/// Number of pixels of a sphere at the center of the picture.
inline double silhouette_area(const Camera& camera, double radius, int height) {
  const double distance = norm(camera.eye - camera.target);
  const double pixels = std::tan(std::asin(radius / distance)) / camera_frame(camera).tan_half * 0.5 * height;
  return std::numbers::pi * pixels * pixels;
}

}  // namespace turgor::test
