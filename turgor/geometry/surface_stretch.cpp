#include "turgor/geometry/surface_stretch.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// Products of two edges of a triangle.
struct Metric {
  double aa = 0, ab = 0, bb = 0;  // [m²]

  explicit Metric(const std::array<Vec3d, 3>& x) {
    const Vec3d a = x[1] - x[0], b = x[2] - x[0];
    aa = dot(a, a), ab = dot(a, b), bb = dot(b, b);
  }
  double determinant() const { return aa * bb - ab * ab; }
};

/// A triangle at rest.
struct StretchedTriangle {
  Vec3d center;                  // [m]
  double area = 0, stretch = 0;  // twice the area [m²] [1]
};
StretchedTriangle stretched(std::span<const Vec3> rest, std::span<const Vec3> now, Int3 t) {
  const auto corners = [t](std::span<const Vec3> x) {
    return std::array{Vec3d(x[std::size_t(t.x)]), Vec3d(x[std::size_t(t.y)]), Vec3d(x[std::size_t(t.z)])};
  };
  const std::array<Vec3d, 3> before = corners(rest), after = corners(now);
  return {(before[0] + before[1] + before[2]) / 3, norm(cross(before[1] - before[0], before[2] - before[0])),
          principal_stretch(before, after)};
}

/// Cube of a grid.
using Cube = std::tuple<int, int, int>;
Cube cube_of(Vec3d x, double size) {
  return {int(std::floor(x.x / size)), int(std::floor(x.y / size)), int(std::floor(x.z / size))};
}

}  // namespace

double principal_stretch(const std::array<Vec3d, 3>& rest, const std::array<Vec3d, 3>& now) {
  const Metric before(rest), after(now);
  const double area = before.determinant();
  if (!(area > 0)) return 0;
  // λ⁴ − t λ² + d = 0
  const double t = (before.bb * after.aa - 2 * before.ab * after.ab + before.aa * after.bb) / area,
               d = after.determinant() / area;
  return std::sqrt(std::max(0.0, 0.5 * (t + std::sqrt(std::max(0.0, t * t - 4 * d)))));
}

std::vector<float> principal_stretches(std::span<const Vec3> rest, std::span<const Vec3> now,
                                       std::span<const Int3> triangles) {
  TURGOR_ASSERT(rest.size() == now.size(), "every vertex has a position at rest");
  std::vector<double> sums(rest.size()), areas(rest.size());
  for (const Int3 t : triangles) {
    const StretchedTriangle triangle = stretched(rest, now, t);
    for (const int n : {t.x, t.y, t.z})
      sums[std::size_t(n)] += triangle.area * triangle.stretch, areas[std::size_t(n)] += triangle.area;
  }
  std::vector<float> means(rest.size(), 1);
  for (std::size_t n = 0; n < means.size(); n++)
    if (areas[n] > 0) means[n] = float(sums[n] / areas[n]);
  return means;
}

DiscStretch largest_stretch_of_discs(std::span<const Vec3> rest, std::span<const Vec3> now,
                                     std::span<const Int3> triangles, double radius) {
  TURGOR_ASSERT(rest.size() == now.size() && radius > 0,
                "discs of a radius on vertices with a position at rest");
  // triangles by cubes of the radius' size
  std::map<Cube, std::vector<StretchedTriangle>> cubes;
  for (const Int3 t : triangles) {
    const StretchedTriangle triangle = stretched(rest, now, t);
    cubes[cube_of(triangle.center, radius)].push_back(triangle);
  }
  const auto mean_around = [&](Vec3d x) {
    double sum = 0, area = 0;
    const auto [i, j, k] = cube_of(x, radius);
    for (int n = 0; n < 27; n++) {
      const auto cube = cubes.find({i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1});
      if (cube == cubes.end()) continue;
      for (const StretchedTriangle& t : cube->second)
        if (norm(t.center - x) <= radius) sum += t.area * t.stretch, area += t.area;
    }
    return area > 0 ? sum / area : 1;
  };
  // vertices of triangles
  std::vector<bool> is_used(rest.size());
  for (const Int3 t : triangles)
    for (const int n : {t.x, t.y, t.z}) is_used[std::size_t(n)] = true;
  DiscStretch largest{.mean = 0};
  for (std::size_t v = 0; v < rest.size(); v++) {
    if (!is_used[v]) continue;
    const double mean = mean_around(Vec3d(rest[v]));
    if (mean > largest.mean) largest = {v, mean};
  }
  return largest.mean > 0 ? largest : DiscStretch{};
}

}  // namespace turgor
