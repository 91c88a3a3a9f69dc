#include "turgor/models/sfem/surface_strain.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::sfem {

namespace {

/// Metric of a triangle: products of two of its edges.
struct Metric {
  double aa = 0, ab = 0, bb = 0;  // [m²]
};
Metric metric(Vec3d p, Vec3d q, Vec3d r) {
  const Vec3d a = q - p, b = r - p;
  return {dot(a, a), dot(a, b), dot(b, b)};
}

/// Largest |½ (λ² − 1)|; λ² are the eigenvalues of the metrics' quotient.
double triangle_strain(const Metric& rest, const Metric& now) {
  const double area2 = rest.aa * rest.bb - rest.ab * rest.ab;
  if (!(area2 > 0)) return 0;
  const double trace = (rest.bb * now.aa - 2 * rest.ab * now.ab + rest.aa * now.bb) / area2;
  const double det = (now.aa * now.bb - now.ab * now.ab) / area2;
  const double half = trace / 2, root = std::sqrt(std::max(0.0, half * half - det));
  return 0.5 * std::max(std::abs(half + root - 1), std::abs(half - root - 1));
}

/// Largest strain of triangles whose vertices are at rest(vertex) and now(vertex).
template <class Rest, class Now>
double largest_strain(std::span<const Int3> triangles, const Rest& rest, const Now& now) {
  double largest = 0;
  for (const Int3 t : triangles)
    largest = std::max(largest, triangle_strain(metric(rest(t.x), rest(t.y), rest(t.z)),
                                                metric(now(t.x), now(t.y), now(t.z))));
  return largest;
}

}  // namespace

double largest_surface_strain(std::span<const Int3> triangles, std::span<const Vec3d> rest,
                              std::span<const Vec3d> x) {
  TURGOR_ASSERT(x.size() == rest.size(), "one position a vertex");
  return largest_strain(
      triangles, [&](int v) { return rest[std::size_t(v)]; }, [&](int v) { return x[std::size_t(v)]; });
}

double largest_surface_strain(const Patch& patch, std::span<const Vec3d> x) {
  TURGOR_ASSERT(x.size() == patch.points.size(), "one position a point");
  return largest_strain(
      patch.triangles, [&](int v) { return patch.points[std::size_t(v)].x; },
      [&](int v) { return x[std::size_t(v)]; });
}

}  // namespace turgor::sfem
