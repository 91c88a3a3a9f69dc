// Every ray takes steps of the smallest spacing, leaps over blocks in which nothing is visible, and ends when
// nothing more would shine through. Shading: Lambert and Blinn with the normal along the gradient of the
// values, two-sided; weak gradients are noise and are shaded flat. Hollows are darkened by the coarse
// occupancy along the normal. Pixels on edges are traced again with four rays.
#include "turgor/view/volume_view.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/view/color.hpp"
#include "turgor/view/lights.hpp"
#include "turgor/view/opacity_blocks.hpp"
#include "turgor/view/sample.hpp"
#include "turgor/view/smooth.hpp"

namespace turgor {

namespace {

constexpr float kLeastTransmittance = 0.004f;
constexpr float kNoise =
    12;  // smoothed neighbours that differ by much less are noise, by much more a surface [HU]
constexpr float kSolid = 0.12f;    // a step that hides more than this is drawn with all care
constexpr int kTile = 16;          // pixels
constexpr int kEdgeContrast = 14;  // of two neighbouring pixels, in a colour byte, that makes an edge

struct Ray {
  Vec3 start, step;   // index; per step
  Vec3 direction;     // unit, patient frame
  Vec3 entry_normal;  // of the volume's face where the ray comes in, patient frame
  int last = -1;      // steps to take; < 0: misses the volume
};

struct RayCaster {
  const CtVolume& ct;
  const CtVolume& smooth;
  const Transfer& transfer;
  const OpacityBlocks& blocks;
  Lights lights;
  CameraFrame frame;
  Mat3d to_index;  // index per metre
  Mat3d gradient_to_patient;
  Vec3d eye;             // index
  float step;            // [m]
  float noise_gradient;  // [HU/m]
  int width, height;

  Vec3 pixel(float x, float y) const;

 private:
  Ray make_ray(float x, float y) const;
  Vec3 gradient(Vec3 index) const;
  Vec3 lit(Vec3 color, Vec3 index, const Ray& ray, bool at_entry, bool solid) const;
  float openness(Vec3 index, Vec3 normal) const;
  float surface_place(float before, float here) const;
  int leap(const Ray& ray, Vec3 index, int distance) const;
};

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

// `solid` places are worth the light that their surroundings take away, and a highlight.
Vec3 RayCaster::lit(Vec3 color, Vec3 index, const Ray& ray, bool at_entry, bool solid) const {
  const Vec3 g = gradient(index);
  const float magnitude = norm(g);
  float surface = magnitude * magnitude / (magnitude * magnitude + noise_gradient * noise_gradient);
  Vec3 normal = magnitude > 0 ? g / -magnitude : -ray.direction;
  if (at_entry) normal = ray.entry_normal, surface = 1;
  if (dot(normal, ray.direction) > 0) normal = -normal;

  const float key = std::max(0.0f, dot(normal, lights.key)), fill = std::max(0.0f, dot(normal, lights.fill));
  const float rim = std::max(0.0f, dot(normal, lights.rim)), sky = 0.5f + 0.5f * dot(normal, lights.up);
  const float open = solid ? openness(index, normal) : 0.8f;
  const Vec3 ambient = (lights.floor_color + (lights.sky_color - lights.floor_color) * sky) * open;
  const Vec3 shaded =
      lights.key_color * (key * (0.35f + 0.65f * open)) + lights.fill_color * fill + lights.rim_color * rim;
  const Vec3 flat = lights.key_color * (0.45f * open);
  const Vec3 matt = hadamard(color, ambient + flat + (shaded - flat) * surface);
  if (!solid) return matt;
  const float half_angle = std::max(0.0f, dot(normal, normalized(lights.key - ray.direction)));
  return matt + lights.key_color * (0.10f * surface * open * std::pow(half_angle, 28.0f));
}

// Where between two samples, 0…1, the light that a segment sends comes from: the values in between are taken
// to change linearly, each part hides those behind it.
float RayCaster::surface_place(float before, float here) const {
  constexpr int kParts = 6;
  float weights = 0, sum = 0, transmittance = 1;
  for (int part = 0; part < kParts; part++) {
    const float place = (float(part) + 0.5f) / kParts;
    const float hu = before + (here - before) * place;
    const float alpha = 1 - std::exp(-transfer.extinction(int(std::lround(hu))) * step / kParts);
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

Vec3 RayCaster::pixel(float x, float y) const {
  const Vec3 behind = backdrop(x / float(width), y / float(height));
  const Ray ray = make_ray(x, y);
  const Vec3 last_index = Vec3(Vec3d(ct.grid.size) - Vec3d{1, 1, 1});
  const auto place = [&](int n) { return min(max(ray.start + ray.step * float(n), Vec3{}), last_index); };
  Vec3 light;
  float transmittance = 1, before = 0;
  bool have_before = false;
  for (int n = 0; n <= ray.last && transmittance > kLeastTransmittance;) {
    const Vec3 index = place(n);
    const Int3 block{int(index.x) / kBlock, int(index.y) / kBlock, int(index.z) / kBlock};
    const int distance =
        blocks.distance[(std::size_t(block.z) * std::size_t(blocks.size.y) + std::size_t(block.y)) *
                            std::size_t(blocks.size.x) +
                        std::size_t(block.x)];
    if (distance > 0 && !have_before) {
      n += leap(ray, index, distance);
      continue;
    }
    const float here = sample_linear(ct, index);
    if (!have_before) before = n > 0 ? sample_linear(ct, place(n - 1)) : here;
    const Optical optical = transfer.mean(before, here);
    if (optical.extinction > 0) {
      const float alpha = 1 - std::exp(-optical.extinction * step);
      const bool solid = alpha > kSolid;
      const float back = n == 0 ? 0 : solid ? 1 - surface_place(before, here) : 0.5f;
      light += lit(optical.color, index - ray.step * back, ray, n == 0, solid) * (alpha * transmittance);
      transmittance *= 1 - alpha;
    }
    before = here;
    have_before = distance == 0;
    n++;
  }
  return light + behind * transmittance;
}

bool differs(Rgb a, Rgb b) {
  return std::abs(a.r - b.r) > kEdgeContrast || std::abs(a.g - b.g) > kEdgeContrast ||
         std::abs(a.b - b.b) > kEdgeContrast;
}

bool is_edge(const Image& image, int x, int y) {
  const Rgb here = image.at(x, y);
  return (x > 0 && differs(here, image.at(x - 1, y))) ||
         (x + 1 < image.width && differs(here, image.at(x + 1, y))) ||
         (y > 0 && differs(here, image.at(x, y - 1))) ||
         (y + 1 < image.height && differs(here, image.at(x, y + 1)));
}

template <class PixelKernel>
void for_each_pixel(const Exec& exec, int width, int height, const PixelKernel& kernel) {
  const int columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
  parallel_for(exec, std::size_t(columns * rows), [&](std::size_t tile) {
    const int left = int(tile) % columns * kTile, top = int(tile) / columns * kTile;
    for (int y = top; y < std::min(top + kTile, height); y++)
      for (int x = left; x < std::min(left + kTile, width); x++) kernel(x, y);
  });
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

}  // namespace

Image draw_volume(const Exec& exec, const CtVolume& ct, const std::string& preset, const Camera& camera,
                  int width, int height) {
  const std::span<const TransferPoint> points = transfer_points(preset);
  TURGOR_ASSERT(!points.empty(), "the preset of draw_volume is one of volume_presets()");
  const Transfer transfer(points);
  const OpacityBlocks blocks = build_opacity_blocks(exec, ct, transfer);
  const CtVolume smooth = smooth_half(exec, ct);
  const RayCaster caster = make_ray_caster(ct, smooth, transfer, blocks, camera, width, height);

  Image first = make_image(width, height);
  for_each_pixel(exec, width, height, [&](int x, int y) {
    first.at(x, y) = screen_color(caster.pixel(float(x) + 0.5f, float(y) + 0.5f));
  });
  Image image = first;
  for_each_pixel(exec, width, height, [&](int x, int y) {
    if (!is_edge(first, x, y)) return;
    Vec3 sum;
    for (const auto& [u, v] :
         {std::pair{0.375f, 0.125f}, {0.875f, 0.375f}, {0.625f, 0.875f}, {0.125f, 0.625f}})
      sum += caster.pixel(float(x) + u, float(y) + v);
    image.at(x, y) = screen_color(sum / 4);
  });
  return image;
}

}  // namespace turgor
