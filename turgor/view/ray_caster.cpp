// A ray leaps over blocks in which nothing is visible, takes longer steps where little is, and ends when
// nothing more would shine through. Shading: Lambert and Blinn with the normal along the gradient of the
// smoothed values, two-sided; weak gradients are noise and are shaded flat. Hollows are darkened by the
// coarse occupancy along the normal.
#include "turgor/view/ray_caster.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/view/color.hpp"
#include "turgor/view/sample.hpp"

namespace turgor {

namespace {

constexpr float kLeastTransmittance = 0.004f;
constexpr float kSolid = 0.12f;  // a step that hides more than this belongs to a surface
constexpr int kLongStep =
    2;  // steps at once through clouds: blocks share their borders, so none is leapt over
constexpr float kNoise =
    12;  // smoothed neighbours that differ by much less are noise, by much more a surface [HU]

}  // namespace

Ray RayCaster::make_ray(float x, float y) const {
  const double scale = 2 * frame.tan_half / height;
  const Vec3d direction = normalized(frame.right * ((x - 0.5 * width) * scale) -
                                     frame.up * ((y - 0.5 * height) * scale) - frame.back);
  const Vec3d along = to_index * direction;
  double enter = 0, leave = 1e30;
  int face = -1;
  for (int axis = 0; axis < 3; axis++) {
    if (ct.grid.size[axis] < 2) return {};  // nothing to interpolate
    const double last = ct.grid.size[axis] - 1, a = -eye[axis] / along[axis],
                 b = (last - eye[axis]) / along[axis];
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

// By central differences of interpolated values [HU/m].
Vec3 RayCaster::gradient(Vec3 index) const {
  const Vec3 last(Vec3d(smooth.grid.size) - Vec3d{1, 1, 1});
  const Vec3 place = min(max(index * 0.5f - Vec3{0.25f, 0.25f, 0.25f}, Vec3{}), last);
  Vec3d g;
  for (int axis = 0; axis < 3; axis++) {
    Vec3 low = place, high = place;
    low[axis] = std::max(place[axis] - 1, 0.0f);
    high[axis] = std::min(place[axis] + 1, last[axis]);
    g[axis] = (sample_linear(smooth, high) - sample_linear(smooth, low)) / (2 * (high[axis] - low[axis]));
  }
  return Vec3(gradient_to_patient * g);
}

// How much light from around reaches a place: 1 on a plain, less in a hollow.
float RayCaster::openness(Vec3 index, Vec3 normal) const {
  const Vec3 outward(to_index * Vec3d(normal));
  const Vec3 unit = outward / std::max({std::abs(outward.x), std::abs(outward.y), std::abs(outward.z)});
  float open = 1;
  for (int level = 0; level < int(blocks.levels.size()); level++) {
    const float reach = 1.1f * float(kBlock << level);
    open *= 1 - 0.55f * occupancy_at(blocks.levels[std::size_t(level)], level, index + unit * reach);
  }
  return open;
}

Vec3 RayCaster::lit(Vec3 color, Vec3 index, const Ray& ray, bool at_entry) const {
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

// Where between two samples, 0…1, the light that a segment sends comes from: the values in between are taken
// to change linearly, each part hides those behind it.
float RayCaster::surface_place(float before, float here, int steps) const {
  constexpr int kParts = 6;
  float weights = 0, sum = 0, transmittance = 1;
  for (int part = 0; part < kParts; part++) {
    const float place = (float(part) + 0.5f) / kParts;
    const float hu = before + (here - before) * place;
    const float alpha =
        1 - std::exp(-transfer.extinction(int(std::lround(hu))) * step * float(steps) / kParts);
    weights += transmittance * alpha;
    sum += transmittance * alpha * place;
    transmittance *= 1 - alpha;
  }
  return weights > 0 ? sum / weights : 0.5f;
}

// The most steps that stay inside the cube of blocks around `index` that is known to be invisible.
int RayCaster::leap(const Ray& ray, Vec3 index, int distance) const {
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

// A cloud has no surface that could be lit from a side.
Vec3 RayCaster::cloud(Vec3 color) const {
  return hadamard(color, (lights.sky_color + lights.floor_color) * 0.5f + lights.key_color * 0.45f);
}

std::size_t RayCaster::block_at(Vec3 index) const {
  const std::size_t i = std::size_t(index.x) / kBlock, j = std::size_t(index.y) / kBlock,
                    k = std::size_t(index.z) / kBlock;
  return (k * std::size_t(blocks.size.y) + j) * std::size_t(blocks.size.x) + i;
}

Vec3 RayCaster::segment_light(const Ray& ray, const Segment& segment, const Optical& optical,
                              float alpha) const {
  const bool at_entry = segment.end == 0;
  if (alpha < kFaint && !at_entry) return cloud(optical.color);
  const float place = at_entry ? 1 : surface_place(segment.before, segment.here, segment.steps);
  const float steps = float(segment.end) - float(segment.steps) * (1 - place);
  return lit(optical.color, ray.start + ray.step * std::max(steps, 0.0f), ray, at_entry);
}

Vec3 RayCaster::pixel(float x, float y) const {
  const Ray ray = make_ray(x, y);
  const Vec3 last_index = Vec3(Vec3d(ct.grid.size) - Vec3d{1, 1, 1});
  const auto place = [&](int n) { return min(max(ray.start + ray.step * float(n), Vec3{}), last_index); };
  Vec3 light;
  float transmittance = 1;
  Segment segment;
  bool is_near = false;  // the segment starts where something may be visible
  while (segment.end <= ray.last && transmittance > kLeastTransmittance) {
    const Vec3 index = place(segment.end);
    const std::size_t block = block_at(index);
    const int distance = blocks.distance[block];
    if (distance > 0 && !is_near) {
      segment = {.end = segment.end + leap(ray, index, distance)};
      continue;
    }
    segment.here = sample_linear(ct, index);
    if (!is_near) segment.before = segment.end > 0 ? sample_linear(ct, place(segment.end - 1)) : segment.here;
    const Optical optical = transfer.mean(segment.before, segment.here);
    const float alpha = 1 - std::exp(-optical.extinction * step * float(segment.steps));
    if (alpha > kSolid && segment.steps > 1) {  // look again, closely
      segment.end -= segment.steps - 1;
      segment.steps = 1;
      continue;
    }
    if (alpha > 0) light += segment_light(ray, segment, optical, alpha) * (alpha * transmittance);
    transmittance *= 1 - alpha;
    is_near = distance == 0;
    const int steps = distance == 0 && blocks.faint[block] ? kLongStep : 1;
    segment = {.end = segment.end + steps, .steps = steps, .before = segment.here};
  }
  return light + backdrop(x / float(width), y / float(height)) * transmittance;
}

RayCaster make_ray_caster(const CtVolume& ct, const CtVolume& smooth, const Transfer& transfer,
                          const OpacityBlocks& blocks, const Camera& camera, int width, int height) {
  const Vec3d origin = index_at(ct.grid, {});
  const Mat3d to_index{{index_at(ct.grid, {1, 0, 0}) - origin, index_at(ct.grid, {0, 1, 0}) - origin,
                        index_at(ct.grid, {0, 0, 1}) - origin}};
  const CameraFrame frame = camera_frame(camera);
  const Vec3d spacing = ct.grid.spacing;
  const float step = float(std::min({spacing.x, spacing.y, spacing.z}));
  return {.ct = ct,
          .smooth = smooth,
          .transfer = transfer,
          .blocks = blocks,
          .lights = camera_lights(frame),
          .frame = frame,
          .to_index = to_index,
          .gradient_to_patient = transposed(to_index),
          .eye = index_at(ct.grid, camera.eye),
          .step = step,
          .noise_gradient = kNoise / (2 * step),
          .width = width,
          .height = height};
}

}  // namespace turgor
