#include "turgor/sim/tools/tool_mesh.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

constexpr int kAround = 40;

/// Circle of a surface of revolution.
struct Ring {
  double along, radius;  // [m]
};

/// Rings connected by triangles; rings of radius 0 close the ends.
TriMesh round_mesh(const std::vector<Ring>& rings, Vec3d origin, Vec3d axis) {
  TURGOR_CHECK(!rings.empty(), "a round mesh has rings");
  // orthonormal frame around the axis
  const Vec3d z = normalized(axis);
  const Vec3d x = normalized(cross(std::abs(z.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, z)),
              y = cross(z, x);
  // vertices of the rings
  TriMesh mesh;
  for (const Ring& ring : rings)
    for (int a = 0; a < kAround; a++) {
      const double angle = 2 * std::numbers::pi * a / kAround;
      mesh.vertices.push_back(
          Vec3(origin + z * ring.along + (x * std::cos(angle) + y * std::sin(angle)) * ring.radius));
    }
  // two triangles per quad; a ring of zero radius yields one
  for (int r = 0; r + 1 < int(rings.size()); r++)
    for (int a = 0; a < kAround; a++) {
      const int b = (a + 1) % kAround, low = r * kAround, high = low + kAround;
      if (rings[std::size_t(r)].radius > 0) mesh.triangles.push_back({low + a, low + b, high + b});
      if (rings[std::size_t(r) + 1].radius > 0) mesh.triangles.push_back({low + a, high + b, high + a});
    }
  // normals
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

}  // namespace

TriMesh capsule_mesh(double radius, double half_length) {
  TURGOR_CHECK(radius > 0 && half_length >= 0, "a capsule has a radius");
  constexpr int kQuarter = 10;
  std::vector<Ring> rings;
  for (int half = 0; half < 2; half++)
    for (int r = 0; r <= kQuarter; r++) {
      const double angle = 0.5 * std::numbers::pi * ((half ? r : r - kQuarter) / double(kQuarter));
      const bool pole = half ? r == kQuarter : r == 0;
      if (half && r == 0 && half_length == 0) continue;  // skips the second equator
      rings.push_back({(half ? half_length : -half_length) + radius * std::sin(angle),
                       pole ? 0 : radius * std::cos(angle)});
    }
  return round_mesh(rings, {}, {0, 0, 1});
}

TriMesh needle_mesh(double diameter, double cone, double length) {
  const double shoulder = std::min(cone, 0.999 * length);
  return round_mesh({{0, 0}, {shoulder, diameter / 2}, {length, diameter / 2}, {length, 0}}, {}, {0, 0, 1});
}

TriMesh arrow_mesh(Vec3d tail, Vec3d tip, double thickness) {
  const double length = norm(tip - tail), head = std::min(0.4 * length, 3 * thickness);
  return round_mesh({{0, 0},
                     {0, 0.5 * thickness},
                     {length - head, 0.5 * thickness},
                     {length - head, 1.2 * thickness},
                     {length, 0}},
                    tail, tip - tail);
}

}  // namespace turgor
