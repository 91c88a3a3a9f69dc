#include "turgor/models/lattice/surface/tet_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"

namespace turgor::lattice {

namespace {

Vec3d position_of(const FineTet& tet, int corner) {
  return lattice_index(tet.fragments.fine, tet.nodes[std::size_t(corner)]);
}

/// Position of the skin on the edge from the solid corner, as a fraction.
double skin_fraction(const FineTet& tet, int solid, int other) {
  const double a = double(tet.level[std::size_t(solid)]);
  const double b = double(tet.level[std::size_t(other)]);
  return std::clamp(a / (a - b), 0.02, 0.98);
}

Crossing crossing_of(const FineTet& tet, int a, int b) {
  TURGOR_CHECK(is_index(a, 4) && is_index(b, 4) && a != b, "an edge joins two corners of a tetrahedron");
  Crossing found = crossing(tet.fragments, tet.cuts, tet.nodes[std::size_t(a)], tet.nodes[std::size_t(b)]);
  found.fraction = std::clamp(found.fraction, Real(0.01), Real(0.99));
  return found;
}

/// Crossings of one blade with the edges between some fine nodes.
std::vector<Vec3d> crossings_around(const FineTet& tet, std::uint8_t incision, Int3 low, Int3 high) {
  const FineLattice& f = tet.fragments.fine;
  std::vector<Vec3d> positions;
  // visit all edge families of each fine node
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++)
        for (const Int3 edge_offset : kFamilies) {
          const Int3 a{i, j, k}, b = a + edge_offset;
          if (!contains(f, a) || !contains(f, b)) continue;
          // interpolate the position of the crossing
          if (const Crossing c = crossing(tet.fragments, tet.cuts, a, b);
              c.edge && c.edge->incision == incision)
            positions.push_back(lattice_index(f, a) +
                                (lattice_index(f, b) - lattice_index(f, a)) * double(c.fraction));
        }
  return positions;
}

/// Blade in a tetrahedron, as a plane through its crossings with the edges. Empty at the blade's end, where
/// fewer than three edges are cut. If all crossings are close to one corner, or if other blades cut the other
/// edges, the normal comes from the crossings around the tetrahedron.
struct BladePlane {
  Vec3d point, normal;  // [cells]
};
std::optional<BladePlane> blade_plane_in(const FineTet& tet, std::uint8_t incision) {
  constexpr double kSmall = 0.05;  // smallest area that determines a normal [squared fine edges]
  // crossings with the edges
  std::array<Vec3d, 6> at;
  std::size_t count = 0, cut = 0;
  for (int a = 0; a < 4; a++)
    for (int b = a + 1; b < 4; b++)
      if (const Crossing c = crossing_of(tet, a, b); c.edge) {
        cut++;
        if (c.edge->incision != incision) continue;
        const Vec3d from = position_of(tet, a);
        at[count++] = from + (position_of(tet, b) - from) * double(c.fraction);
      }
  if (cut < 3 || count == 0) return {};
  // three crossings span a plane
  const Vec3d subdivisions(tet.fragments.fine.subdivisions);
  if (count >= 3) {
    const Vec3d normal = cross(at[1] - at[0], at[2] - at[0]);
    if (norm(cross(hadamard(at[1] - at[0], subdivisions), hadamard(at[2] - at[0], subdivisions))) > kSmall)
      return BladePlane{at[0], normal};
  }
  // nearly degenerate, or too few: fit the crossings around
  Int3 low = tet.nodes[0], high = tet.nodes[0];
  for (const Int3 node : tet.nodes) low = min(low, node), high = max(high, node);
  const std::vector<Vec3d> around = crossings_around(tet, incision, low, high);
  if (around.size() < 3) return {};
  return BladePlane{at[0], flattest_direction(around)};
}

/// Blade at its end, where a tetrahedron has too few crossings: a plane through one of them, fitted to those
/// around the tetrahedron. Empty if these are fewer than three.
std::optional<BladePlane> blade_plane_at_end(const FineTet& tet, std::uint8_t incision, Vec3d on_blade) {
  Int3 low = tet.nodes[0], high = tet.nodes[0];
  for (const Int3 node : tet.nodes) low = min(low, node), high = max(high, node);
  const std::vector<Vec3d> around =
      crossings_around(tet, incision, low - Int3{1, 1, 1}, high + Int3{1, 1, 1});
  if (around.size() < 3) return {};
  return BladePlane{on_blade, flattest_direction(around)};
}

/// Gradient direction of the level in a tetrahedron, orthogonal to the skin.
Vec3d level_gradient(const FineTet& tet) {
  const Vec3d x0 = position_of(tet, 0);
  const auto level = [&](int n) { return double(tet.level[std::size_t(n)]); };
  const Vec3d a = position_of(tet, 1) - x0, b = position_of(tet, 2) - x0, c = position_of(tet, 3) - x0;
  return cross(b, c) * (level(1) - level(0)) + cross(c, a) * (level(2) - level(0)) +
         cross(a, b) * (level(3) - level(0));
}

/// Moves a point on the skin to the own side of a solid corner, beyond which other blades than `incision` cut
/// fine edges. An edge knows only the first blade that crossed it, so these blades may cut no edge of the
/// tetrahedron. `along` gives the direction of the move from the blade's normal.
template <class Along>
Vec3d to_own_side(const FineTet& tet, int solid, std::uint8_t incision, const Along& along, Vec3d position) {
  const FineLattice& f = tet.fragments.fine;
  const Int3 node = tet.nodes[std::size_t(solid)];
  const Vec3d from = position_of(tet, solid);
  for (const Int3 offset : kFamilies)
    for (const Int3 step : {offset, -offset}) {
      if (!contains(f, node + step)) continue;
      const Crossing c = crossing(tet.fragments, tet.cuts, node, node + step);
      if (c.edge == nullptr || c.edge->incision == incision) continue;
      const Vec3d edge = lattice_index(f, node + step) - from;
      std::optional<BladePlane> blade = blade_plane_in(tet, c.edge->incision);
      if (!blade) blade = blade_plane_at_end(tet, c.edge->incision, from + edge * double(c.fraction));
      if (!blade) continue;
      // distance beyond that blade, positive on the side of the other node
      const Vec3d normal = dot(blade->normal, edge) < 0 ? -blade->normal : blade->normal,
                  move = along(normal);
      const double beyond = dot(position - blade->point, normal), reach = dot(move, normal);
      if (!(beyond > 0) || !(std::abs(reach) > 0.05 * norm(move) * norm(normal))) continue;
      const Vec3d back = move * (beyond / reach);
      if (dot(back, back) < dot(edge, edge)) position -= back;
    }
  return position;
}

/// Skin point on the edge from a solid corner to another one. If the blade crosses that edge below the skin,
/// this point would lie on the wrong side. It is then moved back along the skin onto the blade. At the end of
/// a blade that is not known well enough the point stays, since skin does not sink to a crossing below it.
Vec3d skin_position(const FineTet& tet, int solid, int other) {
  const Vec3d a = position_of(tet, solid), b = position_of(tet, other);
  const double fraction = skin_fraction(tet, solid, other);
  // uncut below the skin
  const Vec3d position = a + (b - a) * fraction;
  if (!tet.is_near_cut) return position;
  const Crossing c = crossing_of(tet, solid, other);
  if (c.edge == nullptr) return position;
  const Vec3d across = level_gradient(tet);
  // another blade may cross the edge first
  const auto along_skin = [across](Vec3d normal) {
    return normal - across * (dot(across, normal) / dot(across, across));
  };
  if (double(c.fraction) >= fraction) return to_own_side(tet, solid, c.edge->incision, along_skin, position);
  // move along the skin, towards the blade
  const Vec3d on_blade = a + (b - a) * double(c.fraction);
  std::optional<BladePlane> blade = blade_plane_in(tet, c.edge->incision);
  if (!blade) blade = blade_plane_at_end(tet, c.edge->incision, on_blade);
  if (!blade) return position;
  const Vec3d along = along_skin(blade->normal);
  const double reach = dot(along, blade->normal), beyond = dot(position - blade->point, blade->normal);
  if (!(reach > 0.05 * dot(blade->normal, blade->normal)))
    return on_blade;  // the blade is tangential to the skin
  const Vec3d back = along * (beyond / reach);
  const bool is_near = dot(back, back) <
                       dot(b - a, b - a);  // the plane approximates a curved blade only within an edge length
  if (!is_near) return on_blade;
  const auto along_line = [line = cross(across, blade->normal)](Vec3d) { return line; };
  return to_own_side(tet, solid, c.edge->incision, along_line, position - back);
}

/// Intersection of two blades with the skin, from a skin point on the second blade. Empty if the blades are
/// nearly parallel, or if it is farther away than the tetrahedron is long.
std::optional<Vec3d> junction_with(const FineTet& tet, std::uint8_t first, std::uint8_t second,
                                   Vec3d position) {
  const std::optional<BladePlane> a = blade_plane_in(tet, first), b = blade_plane_in(tet, second);
  if (!a || !b) return {};
  const Vec3d along = cross(level_gradient(tet), b->normal);
  const double reach = dot(along, a->normal);
  if (!(std::abs(reach) > 0.3 * norm(along) * norm(a->normal))) return {};
  const Vec3d move = along * (dot(a->point - position, a->normal) / reach);
  const Vec3d edge = position_of(tet, 3) - position_of(tet, 0);
  if (!(dot(move, move) < 3 * dot(edge, edge))) return {};
  return position + move;
}

/// Fraction of the segment from a to c nearest to the blade's crossing with the edge ij.
double nearest_fraction(const FineTet& tet, Vec3d a, Vec3d c, Vec3d i, Vec3d j, double fraction) {
  const Vec3d step(tet.fragments.fine.cells.spacing);
  const Vec3d direction = hadamard(c - a, step), from = hadamard(i + (j - i) * fraction - a, step);
  return dot(direction, direction) > 0 ? dot(from, direction) / dot(direction, direction) : fraction;
}

}  // namespace

Clip clip_between(const FineTet& tet, int i, int j, int b) {
  const bool swapped = tet.index[std::size_t(i)] > tet.index[std::size_t(j)];  // same result for both sides
  if (swapped) std::swap(i, j);
  const Crossing across = crossing_of(tet, i, j);
  TURGOR_CHECK(across.edge != nullptr, "a clip point is on a blade that crosses the edge");
  const double t = double(across.fraction), from = skin_fraction(tet, i, b), to = skin_fraction(tet, j, b);
  const Crossing at_i = crossing_of(tet, i, b), at_j = crossing_of(tet, j, b);
  // in the triangle with x along ij and y along ib: the skin from (0, from) to (1 − to, to), the blade from
  // (t, 0) to (0, s) or (1 − s, s)
  double fraction = t, up = 0;
  bool is_found = false;
  Clip clip{.position = {},
            .along = double(across.edge->along),
            .incision = across.edge->incision,
            .rightward = across.rightward != swapped};
  const bool below_i = at_i.edge && double(at_i.fraction) < from,
             below_j = at_j.edge && double(at_j.fraction) < to;
  // the blade crosses an edge below the skin: the clip point is that edge's skin point
  if (below_i || below_j) {
    fraction = below_i ? 0 : 1, up = 1, is_found = true;
    clip.along = double((below_i ? at_i : at_j).edge->along);
    // intersection of the two lines
  } else if ((at_i.edge != nullptr) != (at_j.edge != nullptr)) {
    const double s = double(at_i.edge ? at_i.fraction : at_j.fraction);
    const double bx = (at_i.edge ? 0 : 1 - s) - t, by = s, sx = 1 - to, sy = to - from;
    const double det = bx * sy - by * sx;
    if (std::abs(det) > 1e-9) {
      fraction = (bx * (0 - from) - by * (t - 0)) / det, is_found = true;
      up = std::clamp((from + sy * fraction) / by, 0.0, 1.0);
    }
    clip.along += up * (double((at_i.edge ? at_i : at_j).edge->along) - clip.along);
  }
  // another blade crosses an edge below the skin: the intersection of both blades with the skin
  for (const bool is_i : {true, false}) {
    const Crossing& other = is_i ? at_i : at_j;
    if (!(is_i ? below_i : below_j) || other.edge->incision == across.edge->incision) continue;
    const auto junction =
        junction_with(tet, across.edge->incision, other.edge->incision, skin_position(tet, is_i ? i : j, b));
    if (!junction) continue;
    clip.position = *junction, clip.along = double(across.edge->along);
    return clip;
  }
  // position between the skin points
  const Vec3d a = skin_position(tet, i, b), c = skin_position(tet, j, b);
  if (!is_found) fraction = nearest_fraction(tet, a, c, position_of(tet, i), position_of(tet, j), t);
  clip.position = a + (c - a) * std::clamp(fraction, 0.0, 1.0);
  // on the own side of other blades
  const std::optional<BladePlane> blade = blade_plane_in(tet, across.edge->incision);
  if (!blade) return clip;
  const auto along_line = [line = cross(level_gradient(tet), blade->normal)](Vec3d) { return line; };
  for (const int solid : {i, j})
    clip.position = to_own_side(tet, solid, across.edge->incision, along_line, clip.position);
  return clip;
}

namespace {

/// Junction of the three sides on the skin below air corner b. If one blade separates two pairs of the sides,
/// the other blade ends on it: the junction is the position on the first blade nearest to the other one.
/// Otherwise the three blades meet in the middle.
Vec3d junction_at(const FineTet& tet, int b) {
  // intersections of the blades with the skin, one for each pair of sides
  std::array<Clip, 3> clips;
  std::array<int, 3> sides;
  std::size_t count = 0;
  for (int corner = 0; corner < 4; corner++)
    if (corner != b) sides[count++] = corner;
  for (std::size_t n = 0; n < 3; n++) clips[n] = clip_between(tet, sides[n], sides[(n + 1) % 3], b);
  // one blade between two pairs, and the end of another one
  const Vec3d step(tet.fragments.fine.cells.spacing);
  for (std::size_t n = 0; n < 3; n++) {
    const Clip &from = clips[(n + 1) % 3], &to = clips[(n + 2) % 3], &end = clips[n];
    if (from.incision != to.incision || end.incision == from.incision) continue;
    const Vec3d along = hadamard(to.position - from.position, step),
                away = hadamard(end.position - from.position, step);
    const double fraction =
        dot(along, along) > 0 ? std::clamp(dot(away, along) / dot(along, along), 0.0, 1.0) : 0;
    return from.position + (to.position - from.position) * fraction;
  }
  return (clips[0].position + clips[1].position + clips[2].position) / 3;
}

}  // namespace

Vec3d position_of(const FineTet& tet, TetPoint p) {
  // cases of TetPoint
  const Vec3d from = position_of(tet, p.i);
  if (is_corner(p)) return from;
  if (is_skin_point(p)) return skin_position(tet, p.i, p.b);
  if (is_crossing(p)) {
    const double t = double(crossing_of(tet, p.i, p.j).fraction);
    return from + (position_of(tet, p.j) - from) * t;
  }
  if (is_clip(p)) return clip_between(tet, p.i, p.j, p.b).position;
  return junction_at(tet, p.b);
}

}  // namespace turgor::lattice
