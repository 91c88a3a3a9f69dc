#include "turgor/models/lattice/surface/close_ends.hpp"

#include <algorithm>
#include <span>

#include "turgor/models/lattice/surface/middle_of_sides.hpp"

namespace turgor::lattice::detail {

namespace {

constexpr Real kWidest = 4;  // least gape of ends that stay open [steps]

struct MovedVertex {
  std::size_t vertex;
  Vec3 before, shift;  // position before, and its move [m]
};

/// Share of an opening that is closed, at a distance inside a cut: no kink where nothing closes any more.
Real closed_share(Real strength, Real inside) { return strength * (1 - inside * (2 - inside)); }

/// Moves the vertices beside moved ones with the nearest of their side, and less with their distance. A
/// vertex of a lip may have none on the other side that coincided with it, and would be a tooth at the end of
/// the cut.
void move_beside(const CutEnd& end, Real step, const std::vector<MovedVertex>& moved, std::vector<Vec3>& x) {
  const Real reach = step / 2;
  for (const VertexBeside& beside : end.beside) {
    // nearest at rest and by displacement, which differs between both sides
    Real least = reach;
    Vec3 shift;
    for (const VertexBeside::Mover& mover : beside.movers) {
      const MovedVertex& m = moved[std::size_t(mover.index)];
      const Real distance = norm(mover.away) + norm(x[beside.vertex] - m.before - mover.away);
      if (distance < least) least = distance, shift = m.shift;
    }
    x[beside.vertex] += shift * (1 - least / reach);
  }
}

/// Smooths the displacement of the skin around an end. Cells of both sides separate at an end, so a cell
/// ahead of it and those beside it differ at their border by up to the gape there: the skin would have a
/// step. Jacobi iterations of a Laplacian on the surface, whose weight falls to 0 at 2.5 steps.
void smooth_skin(const BodySurface& surface, const std::vector<SkinPoint>& points, std::vector<Vec3>& x) {
  constexpr int kIterations = 12;  // spread a step over a cell, in fine edges of a quarter of it
  const auto displacement = [&](std::size_t v) { return x[v] - surface.rest[v]; };
  std::vector<Vec3> shift(points.size());
  for (int n = 0; n < kIterations; n++) {
    for (std::size_t p = 0; p < points.size(); p++) {
      Vec3 mean;
      for (const std::size_t v : points[p].beside) mean += displacement(v) / Real(points[p].beside.size());
      shift[p] = (mean - displacement(points[p].vertices.front())) * points[p].weight;
    }
    for (std::size_t p = 0; p < points.size(); p++) {
      const Vec3 moved = x[points[p].vertices.front()] + shift[p];
      for (const std::size_t v : points[p].vertices) x[v] = moved;
    }
  }
}

/// Moves vertices that coincided at rest to the middle of their sides at the end of a cut, and less inside
/// it, so that the lips meet in a point: cells open as a whole, and would end in an edge. Ends that gape
/// wider than kWidest steps stay open. On fine lattices the cell at the end of a wide wound gapes by more
/// than its own size.
void close_end(const BodySurface& surface, const CutEnd& end, Real step, std::vector<Vec3>& x) {
  const Real strength = std::min(Real(1), kWidest - norm(x[end.left] - x[end.right]) / step);
  if (!(strength > 0)) return;
  std::vector<MovedVertex> moved;
  for (const ClosingGroup& group : end.groups) {
    const Vec3 middle = middle_of_sides(std::span<const std::size_t>(group.vertices), x);
    const Real share = closed_share(strength, group.inside);
    for (const std::size_t v : group.vertices) moved.push_back({v, x[v], (middle - x[v]) * share});
  }
  for (const MovedVertex& m : moved) x[m.vertex] += m.shift;
  move_beside(end, step, moved, x);
  smooth_skin(surface, end.skin, x);
}

/// Displacements of both sides of the outer tissue at a corner.
struct OpenCorner {
  Vec3 first, apart;  // displacement of one side, and of the other one from it [m]

  Real share(Vec3 u) const { return dot(u - first, apart) / dot(apart, apart); }
};

/// Both sides are those of the outer lips. The tissue between the cuts has lips at the corner, too.
OpenCorner open_corner(const BodySurface& surface, const CutCorner& corner, const std::vector<Vec3>& x) {
  constexpr Real kBeside =
      0.5;  // largest distance of their displacements from the line [distances of the sides]
  const auto u = [&](std::size_t v) { return x[v] - surface.rest[v]; };
  const OpenCorner found{u(corner.first), u(corner.second) - u(corner.first)};
  if (!(dot(found.apart, found.apart) > 0)) return found;
  Real least = 2, most = -2;
  std::size_t first = corner.first, second = corner.first;
  for (const std::size_t v : corner.lips) {
    const Real share = found.share(u(v));
    if (!(norm(u(v) - found.first - found.apart * share) < kBeside * norm(found.apart))) continue;
    if (share < least) least = share, first = v;
    if (share > most) most = share, second = v;
  }
  return {u(first), u(second) - u(first)};
}

/// Moves the outer tissue at a corner so that its two lips meet in a point. A displacement is moved by its
/// share of the distance of both sides, so what lies between them moves little.
void close_corner(const BodySurface& surface, const CutCorner& corner, Real step, std::vector<Vec3>& x) {
  const OpenCorner open = open_corner(surface, corner, x);
  const Real strength = std::min(Real(1), kWidest - norm(open.apart) / step);
  if (!(strength > 0) || !(dot(open.apart, open.apart) > 0)) return;
  for (const CutCorner::Near& near : corner.near) {
    const Real share = std::clamp(open.share(x[near.vertex] - surface.rest[near.vertex]), Real(0), Real(1));
    x[near.vertex] += open.apart * ((Real(0.5) - share) * closed_share(strength, near.inside));
  }
}

}  // namespace

void close_ends(const BodySurface& surface, const CutEnds& ends, Real step, std::vector<Vec3>& x) {
  for (const CutEnd& end : ends.ends) close_end(surface, end, step, x);
  for (const CutCorner& corner : ends.corners) close_corner(surface, corner, step, x);
}

}  // namespace turgor::lattice::detail
