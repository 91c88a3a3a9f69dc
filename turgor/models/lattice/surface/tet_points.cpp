#include "turgor/models/lattice/surface/tet_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

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

/// Blade that cut an edge, near a position.
std::optional<BladePlane> blade_near(const FineTet& tet, const CutEdge& edge, Vec3d position) {
  return blade_plane_near(tet.fragments.fine, tet.cut_points, edge.incision, edge.along, position);
}

/// Gradient direction of the level in a tetrahedron, orthogonal to the skin.
Vec3d level_gradient(const FineTet& tet) {
  const Vec3d x0 = position_of(tet, 0);
  const auto level = [&](int n) { return double(tet.level[std::size_t(n)]); };
  const Vec3d a = position_of(tet, 1) - x0, b = position_of(tet, 2) - x0, c = position_of(tet, 3) - x0;
  return cross(b, c) * (level(1) - level(0)) + cross(c, a) * (level(2) - level(0)) +
         cross(a, b) * (level(3) - level(0));
}

/// Direction along the skin in which the distance to a blade grows fastest. Empty if they are nearly
/// parallel.
std::optional<Vec3d> away_from_blade(const FineTet& tet, Vec3d normal) {
  const Vec3d across = level_gradient(tet);
  const Vec3d along = normal - across * (dot(across, normal) / dot(across, across));
  if (!(dot(along, normal) > 0.05 * dot(normal, normal))) return {};
  return along;
}

/// Moves a point along the skin onto the blade that cut an edge. Empty if the blade is not known there, if it
/// is nearly parallel to the skin, or farther away than the tetrahedron is long.
std::optional<Vec3d> onto_blade(const FineTet& tet, const CutEdge& edge, Vec3d position) {
  const std::array<const CutEdge*, 1> blades{&edge};
  const double longest = norm(position_of(tet, 3) - position_of(tet, 0));
  return SkinOnBlades{tet.fragments.fine, tet.cut_points, tet.levels}(blades, position, longest);
}

/// Intersection of two blades with the skin, near a skin point. Empty if the blades are nearly parallel, or
/// if it is farther away than the tetrahedron is long.
std::optional<Vec3d> junction_with(const FineTet& tet, const CutEdge& first, const CutEdge& second,
                                   Vec3d position) {
  const std::array<const CutEdge*, 2> blades{&first, &second};
  const double longest = norm(position_of(tet, 3) - position_of(tet, 0));
  return SkinOnBlades{tet.fragments.fine, tet.cut_points, tet.levels}(blades, position,
                                                                      std::sqrt(3.0) * longest);
}

/// Moves a point on the skin to the own side of a solid corner, beyond which other blades than `incision` cut
/// fine edges. An edge knows only the first blade that crossed it, so these blades may cut no edge of the
/// tetrahedron. `along` gives the direction of the move from the blade's normal. `on`: blade on which the
/// point lies; null if on none.
template <class Along>
Vec3d to_own_side(const FineTet& tet, int solid, std::uint8_t incision, const CutEdge* on, const Along& along,
                  Vec3d position) {
  const FineLattice& f = tet.fragments.fine;
  const Int3 node = tet.nodes[std::size_t(solid)];
  const Vec3d from = position_of(tet, solid);
  for (const Int3 offset : kFamilies)
    for (const Int3 step : {offset, -offset}) {
      if (!contains(f, node + step)) continue;
      const Crossing c = crossing(tet.fragments, tet.cuts, node, node + step);
      if (c.edge == nullptr || c.edge->incision == incision) continue;
      const std::optional<BladePlane> blade = blade_near(tet, *c.edge, position);
      if (!blade) continue;
      // distance beyond that blade, positive on the side of the other node
      const Vec3d edge = lattice_index(f, node + step) - from;
      const Vec3d normal = dot(blade->normal, edge) < 0 ? -blade->normal : blade->normal,
                  move = along(normal);
      const double beyond = dot(position - blade->point, normal), reach = dot(move, normal);
      if (!(beyond > 0) || !(std::abs(reach) > 0.05 * norm(move) * norm(normal))) continue;
      const Vec3d back = move * (beyond / reach);
      if (!(dot(back, back) < dot(edge, edge))) continue;
      position -= back;
      position = (on ? junction_with(tet, *on, *c.edge, position) : onto_blade(tet, *c.edge, position))
                     .value_or(position);
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
  // another blade may cross the edge first
  if (double(c.fraction) >= fraction) {
    const auto along_skin = [&tet](Vec3d normal) { return away_from_blade(tet, normal).value_or(Vec3d{}); };
    return to_own_side(tet, solid, c.edge->incision, nullptr, along_skin, position);
  }
  // move along the skin, onto the blade
  const std::optional<BladePlane> blade = blade_near(tet, *c.edge, position);
  if (!blade) return position;
  const std::optional<Vec3d> moved = onto_blade(tet, *c.edge, position);
  if (!moved) return a + (b - a) * double(c.fraction);
  const auto along_line = [line = cross(level_gradient(tet), blade->normal)](Vec3d) { return line; };
  return to_own_side(tet, solid, c.edge->incision, c.edge, along_line, *moved);
}

/// Position of the blade on the cut edge between two corners.
Vec3d crossing_position(const FineTet& tet, int i, int j) {
  const bool swapped = tet.index[std::size_t(i)] > tet.index[std::size_t(j)];  // same bits on both sides
  if (swapped) std::swap(i, j);
  const Vec3d from = position_of(tet, i);
  return from + (position_of(tet, j) - from) * double(crossing_of(tet, i, j).fraction);
}

/// Crossing of the cut edge ij on the side of i. An edge knows only the first blade that crossed it. Where
/// another blade crosses it before, seen from i, the tissue of i ends on that blade.
Vec3d crossing_on_own_side(const FineTet& tet, int i, int j) {
  const Vec3d at = crossing_position(tet, i, j);
  if (!tet.has_several_blades) return at;
  const FineLattice& f = tet.fragments.fine;
  const std::uint8_t incision = crossing_of(tet, i, j).edge->incision;
  const Int3 node = tet.nodes[std::size_t(i)];
  const Vec3d from = position_of(tet, i), edge = at - from;
  double fraction = 1;
  for (const Int3 offset : kFamilies)
    for (const Int3 step : {offset, -offset}) {
      if (!contains(f, node + step)) continue;
      const Crossing c = crossing(tet.fragments, tet.cuts, node, node + step);
      if (c.edge == nullptr || c.edge->incision == incision) continue;
      const std::optional<BladePlane> blade = blade_near(tet, *c.edge, from + edge * fraction);
      if (!blade) continue;
      // distances of both ends beyond that blade, positive on the side of the other node
      const double sign = dot(blade->normal, lattice_index(f, node + step) - from) < 0 ? -1 : 1;
      const double begin = sign * dot(from - blade->point, blade->normal),
                   end = sign * dot(at - blade->point, blade->normal);
      if (begin < 0 && end > 0) fraction = std::min(fraction, begin / (begin - end));
    }
  return from + edge * fraction;
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
            .edge = across.edge,
            .rightward = across.rightward != swapped};
  const bool below_i = at_i.edge && double(at_i.fraction) < from,
             below_j = at_j.edge && double(at_j.fraction) < to;
  // the blade crosses an edge below the skin: the clip point is that edge's skin point
  if (below_i || below_j) {
    fraction = below_i ? 0 : 1, up = 1, is_found = true;
    if (const CutEdge* edge = (below_i ? at_i : at_j).edge; edge->incision == clip.edge->incision)
      clip.along = double(edge->along);
    // intersection of the two lines
  } else if ((at_i.edge != nullptr) != (at_j.edge != nullptr)) {
    const double s = double(at_i.edge ? at_i.fraction : at_j.fraction);
    const double bx = (at_i.edge ? 0 : 1 - s) - t, by = s, sx = 1 - to, sy = to - from;
    const double det = bx * sy - by * sx;
    if (std::abs(det) > 1e-9) {
      fraction = (bx * (0 - from) - by * (t - 0)) / det, is_found = true;
      up = std::clamp((from + sy * fraction) / by, 0.0, 1.0);
    }
    if (const CutEdge* edge = (at_i.edge ? at_i : at_j).edge; edge->incision == clip.edge->incision)
      clip.along += up * (double(edge->along) - clip.along);
  }
  // another blade crosses an edge below the skin: the intersection of both blades with the skin
  for (const bool is_i : {true, false}) {
    const Crossing& other = is_i ? at_i : at_j;
    if (!(is_i ? below_i : below_j) || other.edge->incision == across.edge->incision) continue;
    const auto junction = junction_with(tet, *across.edge, *other.edge, skin_position(tet, is_i ? i : j, b));
    if (!junction) continue;
    clip.position = *junction, clip.along = double(across.edge->along);
    return clip;
  }
  // position between the skin points
  const Vec3d a = skin_position(tet, i, b), c = skin_position(tet, j, b);
  if (!is_found) fraction = nearest_fraction(tet, a, c, position_of(tet, i), position_of(tet, j), t);
  clip.position = a + (c - a) * std::clamp(fraction, 0.0, 1.0);
  // a blade that ends in the triangle would fold the skin
  if (at_i.edge || at_j.edge)
    clip.position = onto_blade(tet, *across.edge, clip.position).value_or(clip.position);
  // on the own side of other blades
  const std::optional<BladePlane> blade = blade_near(tet, *across.edge, clip.position);
  if (!blade) return clip;
  const auto along_line = [line = cross(level_gradient(tet), blade->normal)](Vec3d) { return line; };
  for (const int solid : {i, j})
    clip.position = to_own_side(tet, solid, across.edge->incision, across.edge, along_line, clip.position);
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
    if (from.edge->incision != to.edge->incision || end.edge->incision == from.edge->incision) continue;
    if (const auto junction = junction_with(tet, *from.edge, *end.edge, end.position)) return *junction;
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
  if (is_crossing(p)) return crossing_on_own_side(tet, p.i, p.j);
  if (is_clip(p)) return clip_between(tet, p.i, p.j, p.b).position;
  return junction_at(tet, p.b);
}

}  // namespace turgor::lattice
