// Shapes of phantoms, in mm, with the distance to their surface (negative inside, exact to first order near
// it). They are evaluated one row of samples at a time so that the compiler vectorizes the loops. Internal to
// the phantoms.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::phantom {

/// A row of samples at (x + i · dx, y, z) [mm].
struct Row {
  float x, dx, y, z;
  int count;
};

constexpr std::uint16_t kKeepLabel = 65535;
constexpr float kEndless = 1e4f;  // [mm] longer than any volume

/// A density from `inset` below a surface inwards.
struct Layer {
  float inset, hu;  // [mm], [HU]
};

/// A painted shape: layers from outside to inside, and a label, for distance(row) below zero.
struct Shape {
  Vec3 low, high;  // bounds [mm]
  std::vector<Layer> layers;
  std::uint16_t label;
  std::function<void(const Row&, float*)> distance;
};

/// Shapes in painting order; later ones cover earlier ones.
using Anatomy = std::vector<Shape>;

/// `surface(y, z)` returns a function of x: the distance to the surface [mm].
template <class Surface>
void paint(Anatomy& anatomy, Vec3 low, Vec3 high, std::vector<Layer> layers, std::uint16_t label,
           Surface surface) {
  anatomy.push_back({low, high, std::move(layers), label, [surface](const Row& row, float* out) {
                       const auto distance = surface(row.y, row.z);
                       for (int i = 0; i < row.count; i++) out[i] = distance(row.x + float(i) * row.dx);
                     }});
}
template <class Surface>
void paint(Anatomy& anatomy, Vec3 low, Vec3 high, float hu, std::uint16_t label, Surface surface) {
  paint(anatomy, low, high, std::vector<Layer>{{0, hu}}, label, surface);
}

/// A quantity that varies smoothly with z: cubic through points of ascending z, constant beyond them.
class Profile {
 public:
  Profile(std::initializer_list<std::pair<float, float>> points) : points_(points) {}
  float operator()(float z) const;
  float largest() const {
    return std::max_element(points_.begin(), points_.end(),
                            [](auto a, auto b) { return a.second < b.second; })
        ->second;
  }

 private:
  std::vector<std::pair<float, float>> points_;
};

inline float ellipsoid_distance(Vec3 p, Vec3 r) {
  const Vec3 u{p.x / r.x, p.y / r.y, p.z / r.z};
  const Vec3 g{u.x / r.x, u.y / r.y, u.z / r.z};
  const float k0 = std::sqrt(dot(u, u)), k1 = std::sqrt(dot(g, g));
  return k0 * (k0 - 1) / (k1 + 1e-6f);
}

/// |x/a|^2.5 + |y/b|^2.5 = 1: between an ellipse and a rectangle, like the cross section of a trunk.
inline float trunk_distance(float x, float y, float a, float b) {
  const float u = std::abs(x) / a, v = std::abs(y) / b, su = std::sqrt(u), sv = std::sqrt(v);
  const float g = u * u * su + v * v * sv, gx = 2.5f * u * su / a, gy = 2.5f * v * sv / b;
  const float root = 1 - 1.5f / (g + 1.5f);  // keeps the slope near 1 far outside and inside
  return (g - 1) / (std::sqrt(gx * gx + gy * gy) + 0.4f * std::abs(root - 0.4f) / std::min(a, b) + 1e-6f);
}

inline float capsule_distance(Vec3 p, Vec3 a, Vec3 b, float radius) {
  const Vec3 ab = b - a, ap = p - a;
  const float t = std::clamp(dot(ap, ab) / dot(ab, ab), 0.0f, 1.0f);
  return norm(ap - ab * t) - radius;
}

/// Smaller of two distances with a rounded seam of about `width`.
inline float smooth_min(float a, float b, float width) {
  const float h = std::max(width - std::abs(a - b), 0.0f) / width;
  return std::min(a, b) - h * h * width * 0.25f;
}

void paint_ellipsoid(Anatomy& anatomy, Vec3 center, Vec3 radius, float hu, std::uint16_t label = 0);
void paint_capsule(Anatomy& anatomy, Vec3 a, Vec3 b, float radius, float hu, std::uint16_t label = 0);
/// Cortical shell around marrow.
void paint_bone_ellipsoid(Anatomy& anatomy, Vec3 center, Vec3 radius, float cortex, std::uint16_t label = 0);
void paint_bone_capsule(Anatomy& anatomy, Vec3 a, Vec3 b, float radius, float cortex,
                        std::uint16_t label = 0);
/// A couch: a thin curved shell around foam, with its upper side at y in the middle, `half_width` to both
/// sides.
void paint_table(Anatomy& anatomy, float y, float half_width);

// Densities [HU].
constexpr float kSkin = 45, kFat = -100, kMuscle = 55, kLiver = 60, kNodule = 100, kLung = -850, kGas = -980,
                kWater = 5, kCartilage = 130, kMarrow = 220, kCortex = 900, kBlood = 45;

/// Anatomical variation of a seed: a number in [-1, 1] for each `which`.
float variation(std::uint64_t seed, int which);

Anatomy make_torso(std::uint64_t seed);
Anatomy make_head(std::uint64_t seed);
Anatomy make_leg(std::uint64_t seed);

}  // namespace turgor::phantom
