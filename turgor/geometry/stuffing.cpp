#include "turgor/geometry/stuffing.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/manifold.hpp"
#include "turgor/geometry/stuffing_stencils.hpp"

namespace turgor {

namespace {

using stuffing::Corner;
using stuffing::LatticeTet;
using stuffing::Side;

// A lattice point is warped to a cut on one of its edges that is nearer than this fraction of the edge. The
// paper proves its angle bounds for these values.
constexpr double kLongWarp = 0.24999, kShortWarp = 0.41189;

/// Intersection of the surface with a lattice edge.
struct Cut {
  Corner edge;             // from the inside point to the outside point
  bool is_long = false;    // within a grid
  bool discarded = false;  // one end of its edge was warped onto the surface
  double fraction = 0;     // along the edge, from the inside point
  Vec3d position{};        // [m]
};

struct MovedPoint {
  std::int64_t point;
  Vec3d position;  // [m]
};

/// Surface on the lattice: sides of all points, cuts by edge, warped points by number.
struct LatticeSurface {
  std::vector<Side> side;
  std::vector<Cut> cuts;
  std::vector<MovedPoint> moved;
};

std::vector<Side> sides(const LatticeSamples& samples, double level) {
  std::vector<Side> side(samples.distance.size());
  for (std::size_t i = 0; i < side.size(); i++) {
    const double d = double(samples.distance[i]) - level;
    side[i] = d < 0 ? Side::kInside : d > 0 ? Side::kOutside : Side::kOnSurface;
  }
  return side;
}

std::vector<Cut> find_cut_edges(const BccLattice& lattice, const std::vector<Side>& side) {
  std::vector<Cut> cuts;
  for (std::int64_t id = 0; id < point_count(lattice); id++) {
    const Side own_side = side[std::size_t(id)];
    if (own_side == Side::kOnSurface) continue;
    const BccPoint p = point_of(lattice, id);
    const BccNeighbors neighbors = higher_neighbors(p);
    for (int i = 0; i < neighbors.count; i++) {
      const BccPoint q = neighbors.point[std::size_t(i)];
      if (!contains(lattice, q)) continue;
      const std::int64_t other = point_id(lattice, q);
      const Side other_side = side[std::size_t(other)];
      if (other_side == Side::kOnSurface || other_side == own_side) continue;
      const bool inward = own_side == Side::kInside;
      cuts.push_back({{inward ? id : other, inward ? other : id}, p.grid == q.grid});
    }
  }
  std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.edge < b.edge; });
  return cuts;
}

/// Fraction of the edge from a (inside) to b (outside) where the distance equals the level. Illinois method:
/// regula falsi that halves the value of an end that stays.
double find_crossing(const SignedDistance& shape, double level, Vec3d a, Vec3d b, double at_a, double at_b) {
  double low = 0, high = 1, f_low = at_a, f_high = at_b, t = 0.5;
  const double enough = 1e-9 * norm(b - a);
  for (int pass = 0, stayed = 0; pass < 40; pass++) {
    t = low + (high - low) * f_low / (f_low - f_high);
    const double f = shape.at(a * (1 - t) + b * t) - level;
    if (std::abs(f) < enough || high - low < 1e-9) break;
    if (f < 0) {
      low = t, f_low = f;
      if (stayed == 1) f_high /= 2;
      stayed = 1;
    } else {
      high = t, f_high = f;
      if (stayed == -1) f_low /= 2;
      stayed = -1;
    }
  }
  return t;
}

void place_cuts(const Exec& exec, const LatticeSamples& samples, double level, std::vector<Cut>& cuts) {
  const BccLattice& lattice = samples.lattice;
  parallel_for(exec, cuts.size(), [&](std::size_t i) {
    Cut& cut = cuts[i];
    const Vec3d a = place_of(lattice, point_of(lattice, cut.edge.point)),
                b = place_of(lattice, point_of(lattice, cut.edge.to));
    cut.fraction = find_crossing(samples.shape, level, a, b,
                                 double(samples.distance[std::size_t(cut.edge.point)]) - level,
                                 double(samples.distance[std::size_t(cut.edge.to)]) - level);
    cut.position = a * (1 - cut.fraction) + b * cut.fraction;
  });
}

/// A cut and a point at one end of its edge.
struct CutAtPoint {
  std::int64_t point;
  std::size_t cut;
  double distance;  // from the point, in cubes; infinite unless the cut is close enough to warp the point
};

std::vector<CutAtPoint> cuts_by_point(const std::vector<Cut>& cuts) {
  std::vector<CutAtPoint> list;
  for (std::size_t c = 0; c < cuts.size(); c++) {
    const double length = cuts[c].is_long ? 1 : std::sqrt(0.75),
                 limit = cuts[c].is_long ? kLongWarp : kShortWarp;
    const auto distance = [&](double f) { return f < limit ? f * length : INFINITY; };
    list.push_back({cuts[c].edge.point, c, distance(cuts[c].fraction)});
    list.push_back({cuts[c].edge.to, c, distance(1 - cuts[c].fraction)});
  }
  std::sort(list.begin(), list.end(), [](const CutAtPoint& a, const CutAtPoint& b) {
    return a.point != b.point ? a.point < b.point : a.cut < b.cut;
  });
  return list;
}

/// Warps points onto the surface at a cut that is too close; their other cuts are discarded.
void warp(LatticeSurface& surface) {
  const std::vector<CutAtPoint> list = cuts_by_point(surface.cuts);
  for (std::size_t begin = 0; begin < list.size();) {
    std::size_t end = begin, nearest = begin;
    double distance = INFINITY;
    for (; end < list.size() && list[end].point == list[begin].point; end++)
      if (!surface.cuts[list[end].cut].discarded && list[end].distance < distance)
        nearest = end, distance = list[end].distance;
    if (distance < INFINITY) {
      surface.side[std::size_t(list[begin].point)] = Side::kOnSurface;
      surface.moved.push_back({list[begin].point, surface.cuts[list[nearest].cut].position});
      for (std::size_t i = begin; i < end; i++) surface.cuts[list[i].cut].discarded = true;
    }
    begin = end;
  }
}

/// Inner tetrahedra of all lattice tetrahedra, four corners each.
std::vector<Corner> fill(const BccLattice& lattice, const std::vector<Side>& side) {
  std::vector<Corner> corners;
  for (std::int64_t id = 0; id < grid_points(lattice); id++)
    for (int axis = 0; axis < 3; axis++)
      for (const auto& points : tetrahedra_around(point_of(lattice, id).index, axis)) {
        LatticeTet tet{points, {}, {}};
        const auto known = [&](const BccPoint& p) { return contains(lattice, p); };
        if (!std::all_of(points.begin(), points.end(), known)) continue;
        for (std::size_t c = 0; c < 4; c++) {
          tet.id[c] = point_id(lattice, points[c]);
          tet.side[c] = side[std::size_t(tet.id[c])];
        }
        append_inside(tet, corners);
      }
  return corners;
}

Vec3d place_of(const BccLattice& lattice, const LatticeSurface& surface, const Corner& corner) {
  if (corner.to >= 0)
    return std::lower_bound(surface.cuts.begin(), surface.cuts.end(), corner,
                            [](const Cut& cut, const Corner& edge) { return cut.edge < edge; })
        ->position;
  const auto moved =
      std::lower_bound(surface.moved.begin(), surface.moved.end(), corner.point,
                       [](const MovedPoint& m, std::int64_t point) { return m.point < point; });
  if (moved != surface.moved.end() && moved->point == corner.point) return moved->position;
  return place_of(lattice, point_of(lattice, corner.point));
}

/// Numbers the corners that are used.
SolidMesh to_mesh(const BccLattice& lattice, const LatticeSurface& surface,
                  const std::vector<Corner>& corners) {
  std::vector<Corner> used = corners;
  sort_unique(used);
  SolidMesh mesh;
  for (const Corner& corner : used) mesh.vertices.push_back(place_of(lattice, surface, corner));
  for (const Corner& corner : corners)
    mesh.elements.push_back(int(std::lower_bound(used.begin(), used.end(), corner) - used.begin()));
  return mesh;
}

}  // namespace

BccLattice lattice_around(const SignedDistance& shape, double size, double margin) {
  TURGOR_ASSERT(size > 0, "a lattice has a size");
  const Vec3d reach = Vec3d{1, 1, 1} * (margin + 1.5 * size), extent = shape.high - shape.low + reach * 2.0;
  const auto points = [&](double length) { return int(std::ceil(length / size)) + 1; };
  return {shape.low - reach, size, {points(extent.x), points(extent.y), points(extent.z)}};
}

LatticeSamples sample(const Exec& exec, SignedDistance shape, const BccLattice& lattice,
                      const Progress& progress) {
  constexpr std::size_t kBlock = 1 << 18;  // points between two calls of progress
  const std::size_t count = std::size_t(point_count(lattice));
  LatticeSamples samples{std::move(shape), lattice, std::vector<float>(count)};
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t block = std::min(kBlock, count - begin);
    parallel_for(
        exec, block,
        [&](std::size_t n) {
          const std::size_t id = begin + n;
          samples.distance[id] =
              float(samples.shape.at(place_of(lattice, point_of(lattice, std::int64_t(id)))));
        },
        256);
    if (progress) progress(double(begin + block) / double(count));
  }
  return samples;
}

SolidMesh stuff(const Exec& exec, const LatticeSamples& samples, double level) {
  LatticeSurface surface{sides(samples, level), {}, {}};
  surface.cuts = find_cut_edges(samples.lattice, surface.side);
  place_cuts(exec, samples, level, surface.cuts);
  warp(surface);
  return make_manifold(to_mesh(samples.lattice, surface, fill(samples.lattice, surface.side)));
}

}  // namespace turgor
