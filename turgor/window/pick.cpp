#include "turgor/window/pick.hpp"

#include <cmath>

namespace turgor {

namespace {

/// Intersection of a ray with a triangle.
struct Hit {
  double distance;              // along the ray [m]
  std::array<double, 3> share;  // barycentric coordinates
};

/// Empty if the ray misses. [Möller, Trumbore 1997]
std::optional<Hit> hit_of(const SightRay& ray, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, ac = c - a, p = cross(ray.direction, ac), s = ray.from - a, q = cross(s, ab);
  const double volume = dot(ab, p);
  if (volume == 0) return std::nullopt;
  const double u = dot(s, p) / volume, v = dot(ray.direction, q) / volume, t = dot(ac, q) / volume;
  if (u < 0 || v < 0 || u + v > 1 || !(t > 0)) return std::nullopt;
  return Hit{t, {1 - u - v, u, v}};
}

}  // namespace

std::optional<Picked> pick_surface(std::span<const Vec3> x, std::span<const Int3> triangles,
                                   const SightRay& ray) {
  std::optional<Picked> nearest;
  for (std::size_t n = 0; n < triangles.size(); n++) {
    const Int3 t = triangles[n];
    const Vec3d a(x[std::size_t(t.x)]), b(x[std::size_t(t.y)]), c(x[std::size_t(t.z)]);
    const std::optional<Hit> hit = hit_of(ray, a, b, c);
    if (!hit || (nearest && hit->distance >= nearest->distance)) continue;
    nearest = Picked{.body = 0,
                     .point = ray.from + ray.direction * hit->distance,
                     .normal = normalized(cross(b - a, c - a)),
                     .distance = hit->distance,
                     .triangle = n,
                     .share = hit->share};
  }
  return nearest;
}

std::optional<Picked> pick(const WorldSnapshot& snapshot, const SightRay& ray) {
  std::optional<Picked> nearest;
  for (std::size_t b = 0; b < snapshot.bodies.size(); b++) {
    std::optional<Picked> found = pick_surface(snapshot.bodies[b].x, snapshot.bodies[b].triangles, ray);
    if (!found || (nearest && found->distance >= nearest->distance)) continue;
    found->body = b, nearest = found;
  }
  return nearest;
}

}  // namespace turgor
