#include "turgor/models/lattice/surface/close_ends.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/surface/middle_of_sides.hpp"

namespace turgor::lattice::detail {

namespace {

constexpr Real kClosing = 2.5;  // length of the lips that close at an end [steps]
constexpr Real kWidest = 4;     // least gape of ends that stay open [steps]
constexpr Real kNear = 0.15;    // distance of lips at a corner of two cuts from it [steps]

/// End of a drawn cut.
struct CutLine {
  const Lip* end = nullptr;  // last lip
  Vec3 back;                 // at rest, along the skin from the end to a lip one step inside; unit
  bool at_begin = false;     // of its path
};

/// End of one incision; empty if it is shorter than a step.
std::optional<CutLine> cut_line(const BodySurface& surface, int incision, bool at_begin, Real step) {
  const auto position = [&](const Lip* lip) { return surface.rest[std::size_t(lip->left)]; };
  const Real sign = at_begin ? Real(1) : Real(-1);
  const Lip *end = nullptr, *inner = nullptr;
  for (const Lip& lip : surface.lips)
    if (lip.incision == incision && (!end || sign * lip.along < sign * end->along)) end = &lip;
  if (!end) return {};
  for (const Lip& lip : surface.lips)
    if (lip.incision == incision && sign * (lip.along - end->along) > step &&
        (!inner || sign * lip.along < sign * inner->along))
      inner = &lip;
  if (!inner) return {};
  const Vec3 back = position(inner) - position(end);
  if (!(norm(back) > 0)) return {};
  return CutLine{end, normalized(back), at_begin};
}

/// True if no other cut is near an end.
bool is_alone(const BodySurface& surface, const CutLine& line, Real step) {
  const Vec3 position = surface.rest[std::size_t(line.end->left)];
  return std::none_of(surface.lips.begin(), surface.lips.end(), [&](const Lip& lip) {
    return lip.incision != line.end->incision &&
           norm(surface.rest[std::size_t(lip.left)] - position) < 2 * step;
  });
}

/// Coordinate along a direction that no plane of the lattice is normal to. Few vertices of a wall share it.
/// Those within a distance of a vertex are within the same distance along it.
Real oblique_coordinate(Vec3 position) {
  constexpr Vec3 kDirection{0.36f, 0.48f, 0.8f};  // unit
  return dot(position, kDirection);
}

/// Groups of at least two vertices that coincide at rest.
std::vector<std::vector<std::size_t>> coincident(const BodySurface& surface, Real tolerance,
                                                 std::vector<std::size_t> vertices) {
  const auto rest = [&](std::size_t v) { return surface.rest[v]; };
  const auto key = [&](std::size_t v) { return oblique_coordinate(surface.rest[v]); };
  std::sort(vertices.begin(), vertices.end(),
            [&](std::size_t a, std::size_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::uint8_t> is_done(vertices.size());
  for (std::size_t a = 0; a < vertices.size(); a++) {
    if (is_done[a]) continue;
    std::vector<std::size_t> group{vertices[a]};
    const Vec3 first = rest(vertices[a]);
    const Real last = key(vertices[a]) + 2 * tolerance;  // twice, for rounded keys
    for (std::size_t b = a + 1; b < vertices.size() && key(vertices[b]) < last; b++)
      if (!is_done[b] && norm(rest(vertices[b]) - first) < tolerance)
        is_done[b] = 1, group.push_back(vertices[b]);
    if (group.size() > 1) groups.push_back(std::move(group));
  }
  return groups;
}

struct MovedVertex {
  std::size_t vertex;
  Vec3 before, shift;  // position before, and its move [m]
};

/// Moves the vertices beside moved ones with the nearest of their side, and less with their distance. A
/// vertex of a lip may have none on the other side that coincided with it, and would be a tooth at the end of
/// the cut.
void move_beside(const BodySurface& surface, Real step, const std::vector<std::size_t>& near,
                 const std::vector<MovedVertex>& moved, std::vector<Vec3>& x) {
  const Real reach = step / 2;
  std::vector<std::size_t> done;
  for (const MovedVertex& m : moved) done.push_back(m.vertex);
  std::sort(done.begin(), done.end());
  // moved vertices by their coordinate
  struct Candidate {
    Real key;
    Vec3 rest;
    const MovedVertex* moved;
  };
  std::vector<Candidate> candidates;
  for (const MovedVertex& m : moved) {
    const Vec3 rest = surface.rest[m.vertex];
    candidates.push_back({oblique_coordinate(rest), rest, &m});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.key != b.key ? a.key < b.key : a.moved < b.moved;
  });
  for (const std::size_t v : near) {
    if (std::binary_search(done.begin(), done.end(), v)) continue;
    // nearest at rest and by displacement, which differs between both sides
    const Real key = oblique_coordinate(surface.rest[v]);
    Real least = reach;
    Vec3 shift;
    const auto is_before = [](const Candidate& c, Real k) { return c.key < k; };
    for (auto c = std::lower_bound(candidates.begin(), candidates.end(), key - reach, is_before);
         c != candidates.end() && c->key < key + reach; ++c) {
      const Vec3 away = surface.rest[v] - c->rest;
      if (dot(away, away) >= least * least) continue;
      const Real distance = norm(away) + norm(x[v] - c->moved->before - away);
      if (distance < least) least = distance, shift = c->moved->shift;
    }
    x[v] += shift * (1 - least / reach);
  }
}

/// Skin at one position.
struct SkinPoint {
  Real weight;                        // of the smoothed displacement [1]
  std::vector<std::size_t> vertices;  // that coincide at rest
  std::vector<std::size_t> beside;    // neighbors on the skin
  Vec3 shift;                         // [m]
};

/// Points of the skin around an end, away from the lips.
std::vector<SkinPoint> skin_points(const BodySurface& surface, const SurfacePlan& plan, Vec3 end, Real step) {
  const Real reach = Real(2.5) * step, margin = Real(0.2) * step, same = Real(1e-3) * step;
  std::vector<Vec3> lips;
  for (const Lip& lip : surface.lips)
    if (const Vec3 at = surface.rest[std::size_t(lip.left)]; norm(at - end) < reach + margin)
      lips.push_back(at);
  const auto is_on_lip = [&](Vec3 at) {
    return std::any_of(lips.begin(), lips.end(), [&](Vec3 lip) { return norm(lip - at) < margin; });
  };
  // vertices in reach, and those among them that coincide
  std::vector<std::size_t> near, grouped;
  for (std::size_t v = 0; v < surface.rest.size(); v++)
    if (norm(surface.rest[v] - end) < reach) near.push_back(v);
  std::vector<std::vector<std::size_t>> groups = coincident(surface, same, near);
  for (const std::vector<std::size_t>& group : groups)
    grouped.insert(grouped.end(), group.begin(), group.end());
  std::sort(grouped.begin(), grouped.end());
  for (const std::size_t v : near)
    if (!std::binary_search(grouped.begin(), grouped.end(), v)) groups.push_back({v});
  // points and their neighbors
  std::vector<SkinPoint> points;
  for (std::vector<std::size_t>& group : groups) {
    const Vec3 at = surface.rest[group.front()];
    const Real left = 1 - norm(at - end) / reach;
    SkinPoint point{left * left, {}, {}, {}};
    for (const std::size_t v : group)
      for (const int corner : plan.triangles_of(v)) {
        if (corner / 3 >= surface.skin_triangles - surface.cap_triangles) continue;
        const Int3 triangle = surface.triangles[std::size_t(corner / 3)];
        for (const int next : {1, 2}) point.beside.push_back(std::size_t(triangle[(corner + next) % 3]));
      }
    if (point.beside.empty() || is_on_lip(at)) continue;
    point.vertices = std::move(group);
    points.push_back(std::move(point));
  }
  return points;
}

/// Smooths the displacement of the skin around an end. Cells of both sides separate at an end, so a cell
/// ahead of it and those beside it differ at their border by up to the gape there: the skin would have a
/// step. Jacobi iterations of a Laplacian on the surface, whose weight falls to 0 at 2.5 steps.
void smooth_skin(const BodySurface& surface, const SurfacePlan& plan, Vec3 end, Real step,
                 std::vector<Vec3>& x) {
  constexpr int kIterations = 12;  // spread a step over a cell, in fine edges of a quarter of it
  std::vector<SkinPoint> points = skin_points(surface, plan, end, step);
  const auto displacement = [&](std::size_t v) { return x[v] - surface.rest[v]; };
  for (int n = 0; n < kIterations; n++) {
    for (SkinPoint& point : points) {
      Vec3 mean;
      for (const std::size_t v : point.beside) mean += displacement(v) / Real(point.beside.size());
      point.shift = (mean - displacement(point.vertices.front())) * point.weight;
    }
    for (const SkinPoint& point : points) {
      const Vec3 moved = x[point.vertices.front()] + point.shift;
      for (const std::size_t v : point.vertices) x[v] = moved;
    }
  }
}

/// Moves vertices that coincided at rest to the middle of their sides at the end of a cut, and less up to
/// kClosing steps inside it, so that the lips meet in a point: cells open as a whole, and would end in an
/// edge. The opening is multiplied by t (2 − t), with t from 0 at the end to 1 inside, which has no kink
/// there. Ends that gape wider than kWidest steps, and ends at which a cut leaves the body, stay open. On
/// fine lattices the cell at the end of a wide wound gapes by more than its own size.
void close_end(const BodySurface& surface, const SurfacePlan& plan, const CutLine& line, Real step,
               std::vector<Vec3>& x) {
  const Vec3 end = surface.rest[std::size_t(line.end->left)];
  const Real gape = norm(x[std::size_t(line.end->left)] - x[std::size_t(line.end->right)]) / step;
  const Real strength = std::min(Real(1), kWidest - gape);
  if (!(strength > 0)) return;
  // vertices near the end
  std::vector<std::size_t> near;
  bool has_tissue_beyond = false;
  for (std::size_t v = 0; v < x.size(); v++) {
    const Vec3 away = surface.rest[v] - end;
    if (norm(away) > (kClosing + Real(0.5)) * step) continue;
    const Real inside = dot(away, line.back);
    const bool is_cut = surface.embedding[v].fragment >= 0;
    has_tissue_beyond |= !is_cut && inside < -step / 4;
    if (is_cut && inside < kClosing * step && inside > -step) near.push_back(v);
  }
  if (!has_tissue_beyond) return;
  // both sides of the cut
  std::vector<MovedVertex> moved;
  for (const std::vector<std::size_t>& group : coincident(surface, Real(1e-3) * step, near)) {
    const Vec3 middle = middle_of_sides(std::span<const std::size_t>(group), x);
    const Vec3 away = surface.rest[group.front()] - end;
    const Real t = std::max(Real(0), dot(away, line.back) / (kClosing * step));
    const Real opening = 1 - strength * (1 - t * (2 - t));
    for (const std::size_t v : group) moved.push_back({v, x[v], (middle - x[v]) * (1 - opening)});
  }
  for (const MovedVertex& m : moved) x[m.vertex] += m.shift;
  move_beside(surface, step, near, moved, x);
  smooth_skin(surface, plan, end, step, x);
}

/// Corner where the ends of two cuts meet and neither goes on.
struct CutCorner {
  Vec3 position;  // at rest, lattice frame [m]
  int first_incision, second_incision;
  int first = 0, second = 0;  // vertices of both outer lips nearest to it
};

/// Outer normal of the skin around the lips near a position at rest. Single triangles there may be inverted.
Vec3 rest_normal(const BodySurface& surface, const SurfacePlan& plan, Vec3 position, Real reach) {
  Vec3 sum;
  for (const Lip& lip : surface.lips) {
    if (norm(surface.rest[std::size_t(lip.left)] - position) > reach) continue;
    for (const int v : {lip.left, lip.right})
      for (const int at : plan.triangles_of(std::size_t(v))) {
        if (at / 3 >= surface.skin_triangles) continue;
        const Int3 t = surface.triangles[std::size_t(at / 3)];
        const Vec3 a = surface.rest[std::size_t(t.x)];
        sum += cross(surface.rest[std::size_t(t.y)] - a, surface.rest[std::size_t(t.z)] - a);
      }
  }
  return sum;
}

/// Corner at which the ends of two incisions meet. Empty if they are apart by more than a step, or if they go
/// on in the same direction.
std::optional<CutCorner> cut_corner(const BodySurface& surface, const SurfacePlan& plan, const CutLine& a,
                                    const CutLine& b, Real step) {
  constexpr Real kMeets = 1;  // [steps]
  const auto rest = [&](int v) { return surface.rest[std::size_t(v)]; };
  if (norm(rest(a.end->left) - rest(b.end->left)) > kMeets * step) return {};
  // the tissue between both cuts lies on the side of the other cut
  const Vec3 normal = rest_normal(surface, plan, rest(a.end->left), step);
  const auto outer = [&](const CutLine& own, const CutLine& other) {
    const Vec3 forward = own.at_begin ? own.back : -own.back;
    return dot(cross(forward, normal), other.back) > 0 ? own.end->left : own.end->right;
  };
  if (!(dot(a.back, b.back) > Real(-0.9) * norm(a.back) * norm(b.back))) return {};
  const bool is_beyond = dot(rest(a.end->left) - rest(b.end->left), a.back + b.back) < 0;
  return CutCorner{.position = is_beyond ? rest(a.end->left) : rest(b.end->left),
                   .first_incision = a.end->incision,
                   .second_incision = b.end->incision,
                   .first = outer(a, b),
                   .second = outer(b, a)};
}

/// Displacements of both sides of the outer tissue at a corner.
struct OpenCorner {
  Vec3 first, apart;  // displacement of one side, and of the other one from it [m]

  Real share(Vec3 u) const { return dot(u - first, apart) / dot(apart, apart); }
};

/// Both sides are those of the outer lips. The tissue between the cuts has lips at the corner, too.
OpenCorner open_corner(const BodySurface& surface, const CutCorner& corner, Real step,
                       const std::vector<Vec3>& x) {
  constexpr Real kBeside =
      0.5;  // largest distance of their displacements from the line [distances of the sides]
  const auto u = [&](int v) { return x[std::size_t(v)] - surface.rest[std::size_t(v)]; };
  const OpenCorner found{u(corner.first), u(corner.second) - u(corner.first)};
  if (!(dot(found.apart, found.apart) > 0)) return found;
  Real least = 2, most = -2;
  int first = corner.first, second = corner.first;
  for (const Lip& lip : surface.lips) {
    if (lip.incision != corner.first_incision && lip.incision != corner.second_incision) continue;
    if (norm(surface.rest[std::size_t(lip.left)] - corner.position) > kNear * step) continue;
    for (const int v : {lip.left, lip.right}) {
      const Real share = found.share(u(v));
      if (!(norm(u(v) - found.first - found.apart * share) < kBeside * norm(found.apart))) continue;
      if (share < least) least = share, first = v;
      if (share > most) most = share, second = v;
    }
  }
  return {u(first), u(second) - u(first)};
}

/// Moves the outer tissue at a corner so that its two lips meet in a point. Ends of the cuts lie up to kNear
/// steps apart, and the lips meet up to this distance. A displacement is moved by its share of the distance
/// of both sides, so what lies between them moves little.
void close_corner(const BodySurface& surface, const CutCorner& corner, Real step, std::vector<Vec3>& x) {
  const OpenCorner open = open_corner(surface, corner, step, x);
  const Real strength = std::min(Real(1), kWidest - norm(open.apart) / step);
  if (!(strength > 0) || !(dot(open.apart, open.apart) > 0)) return;
  for (std::size_t v = 0; v < x.size(); v++) {
    const Real beyond = norm(surface.rest[v] - corner.position) / step - kNear;
    const Real t = std::max(Real(0), beyond / (kClosing - kNear));
    if (!(t < 1)) continue;
    const Real share = std::clamp(open.share(x[v] - surface.rest[v]), Real(0), Real(1));
    x[v] += open.apart * ((Real(0.5) - share) * strength * (1 - t * (2 - t)));
  }
}

}  // namespace

void close_ends(const BodySurface& surface, const SurfacePlan& plan, Real step, std::vector<Vec3>& x) {
  // ends of all cuts
  std::vector<int> incisions;
  for (const Lip& lip : surface.lips) incisions.push_back(lip.incision);
  sort_unique(incisions);
  std::vector<CutLine> lines;
  for (const int incision : incisions)
    for (const bool at_begin : {true, false})
      if (const std::optional<CutLine> line = cut_line(surface, incision, at_begin, step))
        lines.push_back(*line);
  // ends alone, and corners of two ends
  for (const CutLine& line : lines)
    if (is_alone(surface, line, step)) close_end(surface, plan, line, step, x);
  for (std::size_t a = 0; a < lines.size(); a++)
    for (std::size_t b = a + 1; b < lines.size(); b++)
      if (lines[a].end->incision != lines[b].end->incision)
        if (const auto corner = cut_corner(surface, plan, lines[a], lines[b], step))
          close_corner(surface, *corner, step, x);
}

}  // namespace turgor::lattice::detail
