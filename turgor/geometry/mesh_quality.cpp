#include "turgor/geometry/mesh_quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

constexpr int kEdge[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// Angle at the edge ab between the half planes through c and d [degrees].
double angle_at_edge(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
  const Vec3d m = cross(b - a, c - a), n = cross(b - a, d - a);
  return std::atan2(norm(cross(m, n)), dot(m, n)) * 180 / std::numbers::pi;
}

}  // namespace

std::array<double, 6> dihedral_angles(const std::array<Vec3d, 4>& x) {
  std::array<double, 6> angles{};
  for (std::size_t e = 0; e < 6; e++) {
    const auto [a, b] = kEdge[e];
    const auto [c, d] = kEdge[5 - e];  // opposite edge
    angles[e] = angle_at_edge(x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)], x[std::size_t(d)]);
  }
  return angles;
}

MeshQuality measure_quality(const SolidMesh& mesh) {
  TURGOR_ASSERT(mesh.corners == 4, "quality is measured on tetrahedra");
  if (element_count(mesh) == 0) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MeshQuality quality{.min_dihedral = 180, .shortest_edge = kInfinity, .smallest_volume = kInfinity};
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    std::array<Vec3d, 4> x;
    for (std::size_t c = 0; c < 4; c++) x[c] = mesh.vertices[std::size_t(element(mesh, e)[c])];
    for (const double angle : dihedral_angles(x)) {
      quality.min_dihedral = std::min(quality.min_dihedral, angle);
      quality.max_dihedral = std::max(quality.max_dihedral, angle);
      quality.dihedral_histogram[std::min<std::size_t>(17, std::size_t(angle / 10))]++;
    }
    for (const auto [a, b] : kEdge) {
      const double length = norm(x[std::size_t(b)] - x[std::size_t(a)]);
      quality.shortest_edge = std::min(quality.shortest_edge, length);
      quality.longest_edge = std::max(quality.longest_edge, length);
    }
    const double v = volume(mesh, e);
    quality.smallest_volume = std::min(quality.smallest_volume, v);
    quality.volume += v;
  }
  return quality;
}

}  // namespace turgor
