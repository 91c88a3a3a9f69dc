// Each half is a ring of three-sided segments; one outer square is extruded into a shank and a jaw.
#include <cmath>
#include <numbers>

#include "turgor/geometry/phantom_liver.hpp"

namespace turgor {

namespace {

constexpr int kRingSegments = 13, kShankSegments = 12;  // 3 · 13 + 4 · 12 = 87 vertices
constexpr double kLength = 0.13;                        // from the tip to the ring's center [m]
constexpr double kHalfGap = 5e-5;                       // between closed jaws [m]
constexpr double kRingRadius = 0.014, kWire = 0.0035;   // [m]

/// Center of the shank, from the ring (0) to the tip (1), and its half thickness across and along the closing
/// direction.
struct ShankSection {
  Vec3d middle;
  double across = 0, along = 0;
};
ShankSection shank_section(double t) {
  const double z = (kLength - kRingRadius - kWire) * (1 - t);
  const double along = 0.0022 - 0.0010 * t;  // half thickness in x
  const double bow = t < 0.8 ? 0.5 * (1 + std::cos(std::numbers::pi * t / 0.8)) : 0;
  return {{along + kHalfGap + 0.016 * bow, 0, z}, 0.0028 - 0.0010 * t, along};
}

void add_ring(TriMesh& mesh) {
  const double middle = shank_section(0).middle.x;
  for (int i = 0; i < kRingSegments; i++) {
    // Half a segment off, so that a segment, not a corner, faces the shank at the ring's lowest point.
    const double a = 2 * std::numbers::pi * (i - 0.5) / kRingSegments - std::numbers::pi / 2;
    const Vec3d outward{std::cos(a), 0, std::sin(a)}, center{middle, 0, kLength};
    for (const auto& [r, y] : {std::pair{kWire, -kWire}, {kWire, kWire}, {-kWire, 0.0}})
      mesh.vertices.push_back(Vec3(center + outward * (kRingRadius + r) + Vec3d{0, y, 0}));
  }
  for (int i = 0; i < kRingSegments; i++)
    for (int side = 0; side < 3; side++) {
      if (i == 0 && side == 0) continue;  // the outer square that is extruded to the shank
      const int next = (i + 1) % kRingSegments, other = (side + 1) % 3;
      const int a = 3 * i + side, b = 3 * next + side, c = 3 * next + other, d = 3 * i + other;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
}

void add_shank(TriMesh& mesh) {
  // order around the square, seen from outside the ring
  Int3 corners{0, 3, 4};
  int last = 1;
  for (int k = 1; k <= kShankSegments; k++) {
    const ShankSection at = shank_section(double(k) / kShankSegments);
    const int first = int(mesh.vertices.size());
    for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
      mesh.vertices.push_back(Vec3(at.middle + Vec3d{x * at.along, y * at.across, 0}));
    const int before[4] = {corners.x, corners.y, corners.z, last};
    for (int i = 0; i < 4; i++) {
      const int j = (i + 1) % 4, a = before[i], b = before[j], c = first + j, d = first + i;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
    corners = {first, first + 1, first + 2}, last = first + 3;
  }
  mesh.triangles.push_back({corners.x, corners.y, corners.z});
  mesh.triangles.push_back({corners.x, corners.z, last});
}

}  // namespace

TriMesh phantom_forceps_half(bool mirrored) {
  TriMesh mesh;
  add_ring(mesh);
  add_shank(mesh);
  if (!mirrored)  // so far clockwise
    for (Int3& t : mesh.triangles) std::swap(t.y, t.z);
  if (mirrored)
    for (Vec3& x : mesh.vertices) x.x = -x.x;
  return mesh;
}

TriMesh phantom_forceps() {
  TriMesh mesh = phantom_forceps_half(false);
  const TriMesh other = phantom_forceps_half(true);
  const int count = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Int3 t : other.triangles) mesh.triangles.push_back({t.x + count, t.y + count, t.z + count});
  return mesh;
}

}  // namespace turgor
