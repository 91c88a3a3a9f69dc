#include "turgor/geometry/phantom_shapes.hpp"

#include "turgor/core/hash.hpp"

namespace turgor::phantom {

namespace {

constexpr float kMargin = 2;  // shapes fade out over a sample outside their surface [mm]

}  // namespace

float Profile::operator()(float z) const {
  const auto& p = points_;
  if (z <= p.front().first) return p.front().second;
  if (z >= p.back().first) return p.back().second;
  std::size_t i = 1;
  while (p[i].first < z) i++;
  const auto slope = [&](std::size_t at) {
    if (at == 0 || at + 1 == p.size()) return 0.0f;
    return (p[at + 1].second - p[at - 1].second) / (p[at + 1].first - p[at - 1].first);
  };
  const float h = p[i].first - p[i - 1].first, t = (z - p[i - 1].first) / h, t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * p[i - 1].second + (t3 - 2 * t2 + t) * h * slope(i - 1) +
         (3 * t2 - 2 * t3) * p[i].second + (t3 - t2) * h * slope(i);
}

void paint_ellipsoid(Anatomy& anatomy, Vec3 c, Vec3 r, float hu, std::uint16_t label) {
  const Vec3 m{kMargin, kMargin, kMargin};
  paint(anatomy, c - r - m, c + r + m, hu, label, [=](float y, float z) {
    return [=](float x) { return ellipsoid_distance({x - c.x, y - c.y, z - c.z}, r); };
  });
}

void paint_capsule(Anatomy& anatomy, Vec3 a, Vec3 b, float radius, float hu, std::uint16_t label) {
  const Vec3 m{radius + kMargin, radius + kMargin, radius + kMargin};
  paint(anatomy, min(a, b) - m, max(a, b) + m, hu, label, [=](float y, float z) {
    return [=](float x) { return capsule_distance({x, y, z}, a, b, radius); };
  });
}

void paint_bone_ellipsoid(Anatomy& anatomy, Vec3 center, Vec3 radius, float cortex, std::uint16_t label) {
  paint_ellipsoid(anatomy, center, radius, kCortex, label);
  paint_ellipsoid(anatomy, center, radius - Vec3{cortex, cortex, cortex}, kMarrow, label);
}

void paint_bone_capsule(Anatomy& anatomy, Vec3 a, Vec3 b, float radius, float cortex, std::uint16_t label) {
  paint_capsule(anatomy, a, b, radius, kCortex, label);
  paint_capsule(anatomy, a, b, radius - cortex, kMarrow, label);
}

void paint_table(Anatomy& anatomy, float top, float half_width) {
  const auto slab = [=](float inset) {
    return [=](float y, float) {
      return [=](float x) {
        const float u = x / half_width, middle = top + 14 - 18 * u * u;  // concave: the sides are higher
        return std::max(std::abs(y - middle) - (14 - inset), std::abs(x) - (half_width - inset));
      };
    };
  };
  const Vec3 low{-half_width - 2, top - 24, -kEndless}, high{half_width + 2, top + 32, kEndless};
  paint(anatomy, low, high, -60, 0, slab(0));
  paint(anatomy, low, high, -920, 0, slab(2.5f));
}

float variation(std::uint64_t seed, int which) {
  const std::uint64_t hash =
      turgor::detail::mix(turgor::detail::mix(kHashSeed, seed), std::uint64_t(which) + 1);
  return float(hash >> 40) / float(1 << 23) - 1;
}

}  // namespace turgor::phantom
