#include "turgor/models/lattice/build/cell_surface.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// A crossing stays this fraction of the edge away from both ends, so that no triangle loses its normal.
constexpr double kLeastDistance = 1e-3;

/// Triangles of a surface, and their moments.
struct SurfaceSum {
  struct Triangle {
    Vec3d center, area;
    std::array<Vec3d, 3> corner;
  };
  std::array<Triangle, 12> triangles;
  int count = 0;
  Vec3d area, moment;
  double plain = 0;  // sum of the areas without direction [m²]

  void add(Vec3d a, Vec3d b, Vec3d c, Vec3d outward) {
    Vec3d normal = cross(b - a, c - a) * 0.5;
    if (dot(normal, outward) < 0) normal = -normal;
    TURGOR_CHECK(count < int(triangles.size()), "a tetrahedron has at most two triangles");
    triangles[std::size_t(count++)] = {(a + b + c) / 3, normal, {a, b, c}};
    area += normal, plain += norm(normal), moment += (a + b + c) * (norm(normal) / 3);
  }
  /// Mean of (d · (x − center)) (e · (x − center)) over the surface [m²].
  double second_moment(Vec3d center, Vec3d d, Vec3d e) const {
    double sum = 0;
    for (int t = 0; t < count; t++) {
      const Triangle& at = triangles[std::size_t(t)];
      double own = dot(at.center - center, d) * dot(at.center - center, e);
      for (const Vec3d x : at.corner) own += dot(x - at.center, d) * dot(x - at.center, e) / 12;
      sum += norm(at.area) * own;
    }
    return sum / plain;
  }
};

/// A cell with its crossings.
struct SurfaceCell {
  Vec3d spacing;
  const std::array<bool, 8>& is_body_corner;
  Int3 lowest;  // node of the whole body
  const CrossingOfEdge& crossing_of;

  static std::size_t corner_of(Int3 o) { return std::size_t(o.x | o.y << 1 | o.z << 2); }
  /// Point of the surface on the edge between a corner in the body and one outside [m].
  Vec3d crossing(Int3 inside, Int3 outside) const {
    const bool up = family_of(outside - inside) >= 0;  // the body corner is the lower end
    const Int3 low = up ? inside : outside, high = up ? outside : inside;
    const EdgeCrossing at = crossing_of(lowest + low, family_of(high - low));
    const double t = up ? 1 - double(at.from_high) : double(at.from_low);
    return hadamard(Vec3d(low) + Vec3d(high - low) * std::clamp(t, kLeastDistance, 1 - kLeastDistance),
                    spacing);
  }
  void add_tet(const std::array<Int3, 4>& tet, SurfaceSum& sum) const {
    // corners on both sides
    std::array<Int3, 4> body, air;
    std::size_t inside = 0, outside = 0;
    for (const Int3 o : tet) {
      if (is_body_corner[corner_of(o)])
        body[inside++] = o;
      else
        air[outside++] = o;
    }
    if (inside == 0 || outside == 0) return;
    Vec3d outward;
    for (std::size_t n = 0; n < outside; n++) outward += hadamard(Vec3d(air[n]), spacing) / double(outside);
    for (std::size_t n = 0; n < inside; n++) outward -= hadamard(Vec3d(body[n]), spacing) / double(inside);
    // a triangle around a single corner, else a quadrilateral
    if (inside == 2) {
      const Vec3d a = crossing(body[0], air[0]), b = crossing(body[0], air[1]), c = crossing(body[1], air[1]),
                  d = crossing(body[1], air[0]);
      sum.add(a, b, c, outward), sum.add(a, c, d, outward);
      return;
    }
    std::array<Vec3d, 3> at;
    for (std::size_t n = 0; n < 3; n++)
      at[n] = inside == 1 ? crossing(body[0], air[n]) : crossing(body[n], air[0]);
    sum.add(at[0], at[1], at[2], outward);
  }
};

/// Sets the reaches along the principal axes of the second moments in the plane of the surface.
void set_reaches(const SurfaceSum& sum, Vec3d center, CellSurface& surface) {
  const Vec3d normal = normalized(sum.area),
              first = normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
              second = cross(normal, first);
  const double xx = sum.second_moment(center, first, first), yy = sum.second_moment(center, second, second),
               xy = sum.second_moment(center, first, second);
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy), middle = 0.5 * (xx + yy),
               half = std::hypot(0.5 * (xx - yy), xy);
  const Vec3d along = first * std::cos(angle) + second * std::sin(angle);
  surface.reach1 = Vec3(along * std::sqrt(middle + half));
  surface.reach2 = Vec3(cross(normal, along) * std::sqrt(std::max(0.0, middle - half)));
}

}  // namespace

double AirLevel::voxel(Int3 at) const {
  const Int3 p = min(max(at, Int3{0, 0, 0}), ct.whole.size - Int3{1, 1, 1});
  if (surroundings.kind(p) == kBodyCell) return ct.row(p.y, p.z)[p.x] - air_max;
  return BodyVoxels(ct, surroundings, air_max)(p) - air_max;
}

double AirLevel::at(Vec3d voxels) const {
  const Vec3d low = voxels - Vec3d{0.5, 0.5, 0.5};
  const Int3 from{int(std::floor(low.x)), int(std::floor(low.y)), int(std::floor(low.z))};
  const Vec3d f = low - Vec3d(from);
  double sum = 0;
  for (int c = 0; c < 8; c++) {
    const Int3 o = Int3{c & 1, c >> 1 & 1, c >> 2};
    const double weight = (o.x ? f.x : 1 - f.x) * (o.y ? f.y : 1 - f.y) * (o.z ? f.z : 1 - f.z);
    if (weight > 0) sum += weight * voxel(from + o);
  }
  return sum;
}

EdgeCrossing cross_edge(const AirLevel& level, Int3 block, Int3 node, int family) {
  const Vec3d low(hadamard(node, block)), offset(hadamard(kFamilies[std::size_t(family)], block));
  const int steps = int(std::max({offset.x, offset.y, offset.z}));
  const auto level_at = [&](int n) { return level.at(low + offset * (double(n) / steps)); };
  // first sample that is body, and the linear crossing before it
  const auto first_body = [&](int from, int step) {
    double before = level_at(from);
    if (before >= 0) return 0.0f;
    for (int n = 1; n <= steps; n++) {
      const double at = level_at(from + n * step);
      if (at >= 0) return float((n - at / (at - before)) / steps);
      before = at;
    }
    return 1.0f;
  };
  return {first_body(0, 1), first_body(steps, -1)};
}

CellSurface surface_in_cell(Int3 cell, int first, Vec3d spacing, const std::array<bool, 8>& is_body_corner,
                            const CrossingOfEdge& crossing) {
  CellSurface surface{.cell = cell, .area = {}, .center = {}, .reach1 = {}, .reach2 = {}};
  SurfaceSum sum;
  const SurfaceCell crossed{spacing, is_body_corner, cell + Int3{0, 0, first}, crossing};
  for (const auto& tet : kKuhnTets) crossed.add_tet(tet, sum);
  // opposite sheets cancel
  if (!(norm(sum.area) > 1e-3 * sum.plain)) return surface;
  const Vec3d center = sum.moment / sum.plain;
  surface.area = Vec3(sum.area), surface.center = Vec3(center);
  set_reaches(sum, center, surface);
  return surface;
}

}  // namespace turgor::lattice
