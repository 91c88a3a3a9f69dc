#include "turgor/models/lattice/surface/tet_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/models/lattice/cutting/crack_tips.hpp"

namespace turgor::lattice {

namespace {

Vec3d place_of(const FineTet& tet, int corner) {
  return lattice_index(tet.pieces.fine, tet.nodes[std::size_t(corner)]);
}

/// How far from the solid corner towards the other one the skin is.
double skin_fraction(const FineTet& tet, int solid, int other) {
  const double a = double(tet.level[std::size_t(solid)]);
  const double b = double(tet.level[std::size_t(other)]);
  return std::clamp(a / (a - b), 0.02, 0.98);
}

Crossing crossing_of(const FineTet& tet, int a, int b) {
  Crossing found = crossing(tet.pieces, tet.state, tet.nodes[std::size_t(a)], tet.nodes[std::size_t(b)]);
  found.fraction = std::clamp(found.fraction, Real(0.01), Real(0.99));
  return found;
}

/// Where the blade crosses the edges around some fine nodes.
std::vector<Vec3d> crossings_around(const FineTet& tet, Int3 low, Int3 high) {
  const FineLattice& f = tet.pieces.fine;
  std::vector<Vec3d> places;
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++)
        for (const Int3 way : kFamilies) {
          const Int3 a{i, j, k}, b = a + way;
          if (!contains(f, a) || !contains(f, b)) continue;
          if (const Crossing c = crossing(tet.pieces, tet.state, a, b); c.edge)
            places.push_back(lattice_index(f, a) +
                             (lattice_index(f, b) - lattice_index(f, a)) * double(c.fraction));
        }
  return places;
}

/// The blade inside a tetrahedron: a plane through where it crosses the edges; nothing where it ends. Where
/// it comes by a corner so closely that all crossings are there, its direction is that of the edges around.
struct BladePlane {
  Vec3d point, normal;  // [steps of the lattice]
};
std::optional<BladePlane> blade_in(const FineTet& tet) {
  constexpr double kSmall = 0.05;  // area that tells no direction [squares of fine edges]
  std::array<Vec3d, 6> at;
  std::size_t count = 0;
  for (int a = 0; a < 4; a++)
    for (int b = a + 1; b < 4; b++)
      if (const Crossing c = crossing_of(tet, a, b); c.edge) {
        const Vec3d from = place_of(tet, a);
        at[count++] = from + (place_of(tet, b) - from) * double(c.fraction);
      }
  if (count < 3) return {};
  const Vec3d normal = cross(at[1] - at[0], at[2] - at[0]), parts(tet.pieces.fine.parts);
  if (norm(cross(hadamard(at[1] - at[0], parts), hadamard(at[2] - at[0], parts))) > kSmall)
    return BladePlane{at[0], normal};
  Int3 low = tet.nodes[0], high = tet.nodes[0];
  for (const Int3 node : tet.nodes) low = min(low, node), high = max(high, node);
  return BladePlane{at[0], flattest_way(crossings_around(tet, low, high))};
}

/// Across the skin: how the level changes inside a tetrahedron.
Vec3d level_gradient(const FineTet& tet) {
  const Vec3d x0 = place_of(tet, 0);
  const auto level = [&](int n) { return double(tet.level[std::size_t(n)]); };
  const Vec3d a = place_of(tet, 1) - x0, b = place_of(tet, 2) - x0, c = place_of(tet, 3) - x0;
  return cross(b, c) * (level(1) - level(0)) + cross(c, a) * (level(2) - level(0)) +
         cross(a, b) * (level(3) - level(0));
}

/// Where the skin is on the edge from a solid corner to another one. Where the blade crosses that edge below
/// the skin, the place would lie on its other side: it moves back along the skin, onto the blade.
Vec3d skin_place(const FineTet& tet, int solid, int other) {
  const Vec3d a = place_of(tet, solid), b = place_of(tet, other);
  const double fraction = skin_fraction(tet, solid, other);
  const Vec3d place = a + (b - a) * fraction;
  if (!tet.is_near_cut) return place;
  const Crossing c = crossing_of(tet, solid, other);
  if (c.edge == nullptr || double(c.fraction) >= fraction) return place;
  const Vec3d on_blade = a + (b - a) * double(c.fraction);
  const std::optional<BladePlane> blade = blade_in(tet);
  if (!blade) return on_blade;
  const Vec3d across = level_gradient(tet);
  const Vec3d along = blade->normal - across * (dot(across, blade->normal) / dot(across, across));
  const double reach = dot(along, blade->normal), beyond = dot(place - blade->point, blade->normal);
  if (!(reach > 0.05 * dot(blade->normal, blade->normal))) return on_blade;  // the blade lies in the skin
  const Vec3d back = along * (beyond / reach);
  const bool is_near = dot(back, back) < dot(b - a, b - a);  // a curved blade is a plane for no longer way
  return is_near ? place - back : on_blade;
}

/// Which part of the way from a to c is nearest to where the blade crosses the edge ij.
double nearest_part(const FineTet& tet, Vec3d a, Vec3d c, Vec3d i, Vec3d j, double fraction) {
  const Vec3d step(tet.pieces.fine.cells.step);
  const Vec3d way = hadamard(c - a, step), from = hadamard(i + (j - i) * fraction - a, step);
  return dot(way, way) > 0 ? dot(from, way) / dot(way, way) : fraction;
}

}  // namespace

Clip clip_between(const FineTet& tet, int i, int j, int b) {
  const bool swapped = tet.index[std::size_t(i)] > tet.index[std::size_t(j)];  // the same for both sides
  if (swapped) std::swap(i, j);
  const Crossing across = crossing_of(tet, i, j);
  const double t = double(across.fraction), from = skin_fraction(tet, i, b), to = skin_fraction(tet, j, b);
  const Crossing at_i = crossing_of(tet, i, b), at_j = crossing_of(tet, j, b);
  // In the triangle, x along ij and y along ib: the skin from (0, from) to (1 − to, to), the blade from (t,
  // 0) to (0, s) or (1 − s, s).
  double part = t, up = 0;
  bool known = false;
  Clip clip{.place = {},
            .along = double(across.edge->along),
            .incision = across.edge->incision,
            .rightward = across.rightward != swapped};
  const bool below_i = at_i.edge && double(at_i.fraction) < from,
             below_j = at_j.edge && double(at_j.fraction) < to;
  if (below_i || below_j) {
    part = below_i ? 0 : 1, up = 1, known = true;
    clip.along = double((below_i ? at_i : at_j).edge->along);
  } else if ((at_i.edge != nullptr) != (at_j.edge != nullptr)) {
    const double s = double(at_i.edge ? at_i.fraction : at_j.fraction);
    const double bx = (at_i.edge ? 0 : 1 - s) - t, by = s, sx = 1 - to, sy = to - from;
    const double det = bx * sy - by * sx;
    if (std::abs(det) > 1e-9) {
      part = (bx * (0 - from) - by * (t - 0)) / det, known = true;
      up = std::clamp((from + sy * part) / by, 0.0, 1.0);
    }
    clip.along += up * (double((at_i.edge ? at_i : at_j).edge->along) - clip.along);
  }
  const Vec3d a = skin_place(tet, i, b), c = skin_place(tet, j, b);
  if (!known) part = nearest_part(tet, a, c, place_of(tet, i), place_of(tet, j), t);
  clip.place = a + (c - a) * std::clamp(part, 0.0, 1.0);
  return clip;
}

Vec3d place_of(const FineTet& tet, TetPoint p) {
  const Vec3d from = place_of(tet, p.i);
  if (is_corner(p)) return from;
  if (is_skin_point(p)) return skin_place(tet, p.i, p.b);
  if (is_crossing(p)) {
    const double t = double(crossing_of(tet, p.i, p.j).fraction);
    return from + (place_of(tet, p.j) - from) * t;
  }
  if (is_clip(p)) return clip_between(tet, p.i, p.j, p.b).place;
  Vec3d sum;
  for (int corner = 0; corner < 4; corner++)
    if (corner != p.b) sum += skin_place(tet, corner, p.b) / 3;
  return sum;
}

}  // namespace turgor::lattice
