// Ray casting through a CT. All data is prepared once per picture; a caster is then shared by all threads. A
// ray skips blocks without visible values, takes longer steps through faint ones, and ends when it is opaque.
//
// Shading: Lambert and Blinn, two-sided, with the normal along the gradient of the smoothed values. Weak
// gradients are noise and are shaded flat. Hollows are darkened by the coarse occupancy along the normal.
#pragma once

#include <algorithm>
#include <cmath>

#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"
#include "turgor/view/lights.hpp"
#include "turgor/view/opacity_blocks.hpp"
#include "turgor/view/sample.hpp"
#include "turgor/view/transfer.hpp"

namespace turgor {

/// A ray inside the volume.
struct Ray {
  Vec3 start, step;   // index; per step
  Vec3 direction;     // unit, patient frame
  Vec3 entry_normal;  // normal of the volume's entry face, patient frame
  int last = -1;      // last step; < 0: the ray misses the volume
};

/// A few steps along a ray, from the value `before` to the value `current`.
struct Segment {
  int end = 0, steps = 1;         // last step of the segment; number of steps
  float before = 0, current = 0;  // [HU]
};

/// Data of the rays as plain pointers: the same source runs on CPU threads and on a GPU. Volumes one sample
/// thick are invisible.
struct RayCaster {
  Samples ct, smooth;
  TransferView transfer;
  OpacityBlocksView blocks;
  Lights lights;
  CameraFrame frame;
  Mat3d to_index;  // index per meter
  Mat3d gradient_to_patient;
  Vec3d eye;             // index
  float step;            // [m]
  float noise_gradient;  // [HU/m]
  int width, height;

  /// Linear light at a position of the picture, in pixels from the top left.
  TURGOR_HD Vec3 pixel(float x, float y) const;

 private:
  static constexpr float kLeastTransmittance = 0.004f;
  static constexpr float kSolid = 0.12f;  // opacity of a step above which it belongs to a surface
  /// Steps at once through clouds; blocks share their borders, so none is skipped.
  static constexpr int kLongStep = 2;

  TURGOR_HD Ray make_ray(float x, float y) const;
  TURGOR_HD Vec3 gradient(Vec3 index) const;
  TURGOR_HD Vec3 lit(Vec3 color, Vec3 index, const Ray& ray, bool at_entry) const;
  TURGOR_HD Vec3 cloud(Vec3 color) const;
  TURGOR_HD float openness(Vec3 index, Vec3 normal) const;
  TURGOR_HD float surface_fraction(float before, float current, int steps) const;
  TURGOR_HD std::size_t block_at(Vec3 index) const;
  TURGOR_HD Vec3 segment_light(const Ray& ray, const Segment& segment, const Optical& optical,
                               float alpha) const;
  TURGOR_HD int leap(const Ray& ray, Vec3 index, int distance) const;
};

/// The CT, `smooth` (smooth_half), the transfer function and the blocks must outlive the caster.
RayCaster make_ray_caster(const CtVolume& ct, const CtVolume& smooth, const Transfer& transfer,
                          const OpacityBlocks& blocks, const Camera& camera, int width, int height);
/// The same from views; `grid`: of the CT.
RayCaster make_ray_caster(const Grid& grid, Samples ct, Samples smooth, TransferView transfer,
                          const OpacityBlocksView& blocks, const Camera& camera, int width, int height);

TURGOR_HD inline Ray RayCaster::make_ray(float x, float y) const {
  const double scale = 2 * frame.tan_half / height;
  const Vec3d direction = normalized(frame.right * ((x - 0.5 * width) * scale) -
                                     frame.up * ((y - 0.5 * height) * scale) - frame.back);
  const Vec3d along = to_index * direction;
  double enter = 0, leave = 1e30;
  int face = -1;
  for (int axis = 0; axis < 3; axis++) {
    if (ct.size[axis] < 2) return {};  // nothing to interpolate
    const double last = ct.size[axis] - 1, a = -eye[axis] / along[axis], b = (last - eye[axis]) / along[axis];
    if (along[axis] == 0) {
      if (eye[axis] < 0 || eye[axis] > last) return {};
      continue;
    }
    if (std::min(a, b) > enter) enter = std::min(a, b), face = axis;
    leave = std::min(leave, std::max(a, b));
  }
  if (leave <= enter) return {};
  Ray ray{
      .start = Vec3(eye + along * enter), .step = Vec3(along * double(step)), .direction = Vec3(direction)};
  ray.last = int((leave - enter) / double(step));
  if (face >= 0)
    ray.entry_normal = Vec3(normalized(gradient_to_patient.column[face]) * (along[face] > 0 ? -1.0 : 1.0));
  return ray;
}

// Central differences of interpolated values [HU/m].
TURGOR_HD inline Vec3 RayCaster::gradient(Vec3 index) const {
  const Vec3 last(Vec3d(smooth.size) - Vec3d{1, 1, 1});
  const Vec3 half_index = min(max(index * 0.5f - Vec3{0.25f, 0.25f, 0.25f}, Vec3{}), last);
  Vec3d g;
  for (int axis = 0; axis < 3; axis++) {
    Vec3 low = half_index, high = half_index;
    low[axis] = std::max(half_index[axis] - 1, 0.0f);
    high[axis] = std::min(half_index[axis] + 1, last[axis]);
    g[axis] = (sample_linear(smooth, high) - sample_linear(smooth, low)) / (2 * (high[axis] - low[axis]));
  }
  return Vec3(gradient_to_patient * g);
}

// Fraction of ambient light at a position: 1 on a plane, less in a hollow.
TURGOR_HD inline float RayCaster::openness(Vec3 index, Vec3 normal) const {
  const Vec3 outward(to_index * Vec3d(normal));
  const float longest = std::max(std::max(std::abs(outward.x), std::abs(outward.y)), std::abs(outward.z));
  const Vec3 unit = outward / longest;
  float open = 1;
  for (int level = 0; level < kLevels; level++) {
    const float reach = 1.1f * float(kBlock << level);
    open *= 1 - 0.55f * occupancy_at(blocks.levels[level], level, index + unit * reach);
  }
  return open;
}

TURGOR_HD inline Vec3 RayCaster::lit(Vec3 color, Vec3 index, const Ray& ray, bool at_entry) const {
  const Vec3 g = gradient(index);
  const float magnitude = norm(g);
  float surface = magnitude * magnitude / (magnitude * magnitude + noise_gradient * noise_gradient);
  Vec3 normal = magnitude > 0 ? g / -magnitude : -ray.direction;
  if (at_entry) normal = ray.entry_normal, surface = 1;
  if (dot(normal, ray.direction) > 0) normal = -normal;

  const float key = std::max(0.0f, dot(normal, lights.key)), fill = std::max(0.0f, dot(normal, lights.fill));
  const float rim = std::max(0.0f, dot(normal, lights.rim)), sky = 0.5f + 0.5f * dot(normal, lights.up);
  const float open = openness(index, normal);
  const Vec3 ambient = (lights.floor_color + (lights.sky_color - lights.floor_color) * sky) * open;
  const Vec3 shaded =
      lights.key_color * (key * (0.35f + 0.65f * open)) + lights.fill_color * fill + lights.rim_color * rim;
  const Vec3 flat = lights.key_color * (0.45f * open);
  const Vec3 matt = hadamard(color, ambient + flat + (shaded - flat) * surface);
  const float half_angle = std::max(0.0f, dot(normal, normalized(lights.key - ray.direction)));
  return matt + lights.key_color * (0.10f * surface * open * std::pow(half_angle, 28.0f));
}

// Position in a segment, 0…1, from which its light comes on average. The value is taken as linear, and each
// interval hides those behind it.
TURGOR_HD inline float RayCaster::surface_fraction(float before, float current, int steps) const {
  constexpr int kIntervals = 6;
  float weights = 0, sum = 0, transmittance = 1;
  for (int i = 0; i < kIntervals; i++) {
    const float fraction = (float(i) + 0.5f) / kIntervals;
    const float hu = before + (current - before) * fraction;
    const float alpha =
        1 - std::exp(-transfer.extinction(int(std::lround(hu))) * step * float(steps) / kIntervals);
    weights += transmittance * alpha;
    sum += transmittance * alpha * fraction;
    transmittance *= 1 - alpha;
  }
  return weights > 0 ? sum / weights : 0.5f;
}

// Largest number of steps inside the cube of blocks around `index` that is known to be invisible.
TURGOR_HD inline int RayCaster::leap(const Ray& ray, Vec3 index, int distance) const {
  float steps = 1e9f;
  for (int axis = 0; axis < 3; axis++) {
    if (ray.step[axis] == 0) continue;
    const int block = int(index[axis]) / kBlock;
    const float border =
        float(ray.step[axis] > 0 ? (block + distance) * kBlock : (block - distance + 1) * kBlock);
    steps = std::min(steps, (border - index[axis]) / ray.step[axis]);
  }
  return std::max(1, int(std::ceil(std::max(0.0f, steps))));
}

// A cloud has no surface, so its light does not depend on a normal.
TURGOR_HD inline Vec3 RayCaster::cloud(Vec3 color) const {
  return hadamard(color, (lights.sky_color + lights.floor_color) * 0.5f + lights.key_color * 0.45f);
}

TURGOR_HD inline std::size_t RayCaster::block_at(Vec3 index) const {
  const std::size_t i = std::size_t(index.x) / kBlock, j = std::size_t(index.y) / kBlock,
                    k = std::size_t(index.z) / kBlock;
  return (k * std::size_t(blocks.size.y) + j) * std::size_t(blocks.size.x) + i;
}

TURGOR_HD inline Vec3 RayCaster::segment_light(const Ray& ray, const Segment& segment, const Optical& optical,
                                               float alpha) const {
  const bool at_entry = segment.end == 0;
  if (alpha < kFaint && !at_entry) return cloud(optical.color);
  const float fraction = at_entry ? 1 : surface_fraction(segment.before, segment.current, segment.steps);
  const float steps = float(segment.end) - float(segment.steps) * (1 - fraction);
  return lit(optical.color, ray.start + ray.step * std::max(steps, 0.0f), ray, at_entry);
}

TURGOR_HD inline Vec3 RayCaster::pixel(float x, float y) const {
  const Ray ray = make_ray(x, y);
  const Vec3 last_index = Vec3(Vec3d(ct.size) - Vec3d{1, 1, 1});
  const auto index_at_step = [&](int n) {
    return min(max(ray.start + ray.step * float(n), Vec3{}), last_index);
  };
  Vec3 light;
  float transmittance = 1;
  Segment segment;
  bool is_near = false;  // the segment starts near visible values
  while (segment.end <= ray.last && transmittance > kLeastTransmittance) {
    const Vec3 index = index_at_step(segment.end);
    const std::size_t block = block_at(index);
    const int distance = blocks.distance[block];
    if (distance > 0 && !is_near) {
      segment = {.end = segment.end + leap(ray, index, distance)};
      continue;
    }
    segment.current = sample_linear(ct, index);
    if (!is_near)
      segment.before = segment.end > 0 ? sample_linear(ct, index_at_step(segment.end - 1)) : segment.current;
    const Optical optical = transfer.mean(segment.before, segment.current);
    const float alpha = 1 - std::exp(-optical.extinction * step * float(segment.steps));
    if (alpha > kSolid && segment.steps > 1) {  // repeat with single steps
      segment.end -= segment.steps - 1;
      segment.steps = 1;
      continue;
    }
    if (alpha > 0) light += segment_light(ray, segment, optical, alpha) * (alpha * transmittance);
    transmittance *= 1 - alpha;
    is_near = distance == 0;
    const int steps = distance == 0 && blocks.faint[block] ? kLongStep : 1;
    segment = {.end = segment.end + steps, .steps = steps, .before = segment.current};
  }
  return light + backdrop(x / float(width), y / float(height)) * transmittance;
}

}  // namespace turgor
