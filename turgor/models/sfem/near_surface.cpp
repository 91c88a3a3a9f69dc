#include "turgor/models/sfem/near_surface.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/sfem/lists.hpp"

namespace turgor::sfem {

namespace {

/// Points in cubes of a regular box, to find those near a triangle.
struct Cubes {
  Vec3d low;
  double side = 0;  // [m]
  Int3 count;
  Lists points;  // in each cube

  Int3 cube(Vec3d x) const {
    Int3 at;
    for (int axis = 0; axis < 3; axis++)
      at[axis] = int(std::clamp(std::floor((x[axis] - low[axis]) / side), 0.0, double(count[axis] - 1)));
    return at;
  }
  std::size_t index(Int3 at) const {
    return (std::size_t(at.z) * std::size_t(count.y) + std::size_t(at.y)) * std::size_t(count.x) +
           std::size_t(at.x);
  }
};

Cubes sort_into_cubes(const std::vector<Vec3d>& points, Vec3d low, Vec3d high, double side) {
  constexpr double kMost = 64;  // cubes along an axis
  const Vec3d extent = high - low;
  Cubes cubes{low, std::max(side, std::max({extent.x, extent.y, extent.z}) / kMost), {}, {}};
  for (int axis = 0; axis < 3; axis++) cubes.count[axis] = 1 + int(extent[axis] / cubes.side);
  Lists cube_of;  // of each point, one
  for (const Vec3d x : points) {
    cube_of.item.push_back(int(cubes.index(cubes.cube(x))));
    cube_of.begin.push_back(cube_of.item.size());
  }
  cubes.points = holders(cube_of, cubes.index(cubes.count - Int3{1, 1, 1}) + 1);
  return cubes;
}

}  // namespace

// The part of the plane that p projects into decides: a corner, an edge or the inside. [Ericson 2005, 5.1.5]
Vec3d nearest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, ac = c - a;
  const double a1 = dot(ab, p - a), a2 = dot(ac, p - a);
  if (a1 <= 0 && a2 <= 0) return a;
  const double b1 = dot(ab, p - b), b2 = dot(ac, p - b);
  if (b1 >= 0 && b2 <= b1) return b;
  const double c1 = dot(ab, p - c), c2 = dot(ac, p - c);
  if (c2 >= 0 && c1 <= c2) return c;
  const double to_ab = a1 * b2 - b1 * a2;  // signed areas: negative or zero = beyond that edge
  if (to_ab <= 0 && a1 >= 0 && b1 <= 0) return a + ab * (a1 / (a1 - b1));
  const double to_ac = c1 * a2 - a1 * c2;
  if (to_ac <= 0 && a2 >= 0 && c2 <= 0) return a + ac * (a2 / (a2 - c2));
  const double to_bc = b1 * c2 - c1 * b2;
  if (to_bc <= 0 && b2 >= b1 && c1 >= c2) return b + (c - b) * ((b2 - b1) / ((b2 - b1) + (c1 - c2)));
  return a + ab * (to_ac / (to_ab + to_ac + to_bc)) + ac * (to_ab / (to_ab + to_ac + to_bc));
}

std::vector<std::uint8_t> near_surface(const SolidMesh& mesh, const SolidSurface& surface, double depth) {
  if (mesh.elements.empty()) return {};
  std::vector<Vec3d> centre(element_count(mesh));
  for (std::size_t e = 0; e < centre.size(); e++) centre[e] = centroid(mesh, e);
  std::vector<std::uint8_t> near(centre.size(), 0);
  for (const int e : surface.element) near[std::size_t(e)] = 1;

  Vec3d low = mesh.vertices[std::size_t(mesh.elements[0])], high = low;
  for (const int v : mesh.elements) {
    low = min(low, mesh.vertices[std::size_t(v)]);
    high = max(high, mesh.vertices[std::size_t(v)]);
  }
  if (!(depth < norm(high - low))) return std::vector<std::uint8_t>(centre.size(), 1);
  const Cubes cubes = sort_into_cubes(centre, low, high, depth);
  const auto mark_around = [&](Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d reach{depth, depth, depth};
    const Int3 first = cubes.cube(min(min(a, b), c) - reach), last = cubes.cube(max(max(a, b), c) + reach);
    for (int k = first.z; k <= last.z; k++)
      for (int j = first.y; j <= last.y; j++)
        for (int i = first.x; i <= last.x; i++)
          for (const int e : cubes.points[cubes.index({i, j, k})]) {
            const Vec3d x = centre[std::size_t(e)];
            if (!near[std::size_t(e)] && norm(nearest_on_triangle(x, a, b, c) - x) <= depth)
              near[std::size_t(e)] = 1;
          }
  };
  for (const auto [a, b, c] : surface.triangles)
    mark_around(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)], mesh.vertices[std::size_t(c)]);
  return near;
}

}  // namespace turgor::sfem
