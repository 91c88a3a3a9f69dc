#include "turgor/models/lattice/surface/cut_ends.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"

namespace turgor::lattice::detail {

namespace {

constexpr Real kClosing = 2.5;  // length of the lips that close at an end [steps]
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

/// Vertices beside those of the groups, each with the ones in its reach.
std::vector<VertexBeside> vertices_beside(const BodySurface& surface, Real step,
                                          const std::vector<std::size_t>& near,
                                          const std::vector<ClosingGroup>& groups) {
  const Real reach = step / 2;
  std::vector<std::size_t> moved, done;
  for (const ClosingGroup& group : groups)
    moved.insert(moved.end(), group.vertices.begin(), group.vertices.end());
  done = moved;
  std::sort(done.begin(), done.end());
  // moved vertices by their coordinate
  struct Candidate {
    Real key;
    Vec3 rest;
    int index;
  };
  std::vector<Candidate> candidates;
  for (const std::size_t v : moved)
    candidates.push_back({oblique_coordinate(surface.rest[v]), surface.rest[v], int(candidates.size())});
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  });
  const auto is_before = [](const Candidate& c, Real k) { return c.key < k; };
  std::vector<VertexBeside> found;
  for (const std::size_t v : near) {
    if (std::binary_search(done.begin(), done.end(), v)) continue;
    VertexBeside beside{v, {}};
    const Real key = oblique_coordinate(surface.rest[v]);
    for (auto c = std::lower_bound(candidates.begin(), candidates.end(), key - reach, is_before);
         c != candidates.end() && c->key < key + reach; ++c)
      if (const Vec3 away = surface.rest[v] - c->rest; dot(away, away) < reach * reach)
        beside.movers.push_back({c->index, away});
    if (!beside.movers.empty()) found.push_back(std::move(beside));
  }
  return found;
}

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
    SkinPoint point{left * left, {}, {}};
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

/// End of a cut. Empty if the cut leaves the body there.
std::optional<CutEnd> cut_end(const BodySurface& surface, const SurfacePlan& plan, const CutLine& line,
                              Real step) {
  CutEnd found{std::size_t(line.end->left), std::size_t(line.end->right), {}, {}, {}};
  const Vec3 end = surface.rest[found.left];
  // vertices near the end
  std::vector<std::size_t> near;
  bool has_tissue_beyond = false;
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const Vec3 away = surface.rest[v] - end;
    if (norm(away) > (kClosing + Real(0.5)) * step) continue;
    const Real inside = dot(away, line.back);
    const bool is_cut = surface.embedding[v].fragment >= 0;
    has_tissue_beyond |= !is_cut && inside < -step / 4;
    if (is_cut && inside < kClosing * step && inside > -step) near.push_back(v);
  }
  if (!has_tissue_beyond) return {};
  for (std::vector<std::size_t>& group : coincident(surface, Real(1e-3) * step, near)) {
    const Vec3 away = surface.rest[group.front()] - end;
    const Real inside = std::max(Real(0), dot(away, line.back) / (kClosing * step));
    found.groups.push_back({std::move(group), inside});
  }
  found.beside = vertices_beside(surface, step, near, found.groups);
  found.skin = skin_points(surface, plan, end, step);
  return found;
}

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
  const Vec3 position = is_beyond ? rest(a.end->left) : rest(b.end->left);
  CutCorner corner{std::size_t(outer(a, b)), std::size_t(outer(b, a)), {}, {}};
  for (const Lip& lip : surface.lips)
    if ((lip.incision == a.end->incision || lip.incision == b.end->incision) &&
        norm(rest(lip.left) - position) <= kNear * step)
      corner.lips.insert(corner.lips.end(), {std::size_t(lip.left), std::size_t(lip.right)});
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const Real beyond = norm(surface.rest[v] - position) / step - kNear;
    const Real inside = std::max(Real(0), beyond / (kClosing - kNear));
    if (inside < 1) corner.near.push_back({v, inside});
  }
  return corner;
}

}  // namespace

CutEnds find_cut_ends(const BodySurface& surface, const SurfacePlan& plan, Real step) {
  std::vector<int> incisions;
  for (const Lip& lip : surface.lips) incisions.push_back(lip.incision);
  sort_unique(incisions);
  std::vector<CutLine> lines;
  for (const int incision : incisions)
    for (const bool at_begin : {true, false})
      if (const std::optional<CutLine> line = cut_line(surface, incision, at_begin, step))
        lines.push_back(*line);
  // ends alone, and corners of two ends
  CutEnds found;
  for (const CutLine& line : lines)
    if (is_alone(surface, line, step))
      if (std::optional<CutEnd> end = cut_end(surface, plan, line, step))
        found.ends.push_back(std::move(*end));
  for (std::size_t a = 0; a < lines.size(); a++)
    for (std::size_t b = a + 1; b < lines.size(); b++)
      if (lines[a].end->incision != lines[b].end->incision)
        if (std::optional<CutCorner> corner = cut_corner(surface, plan, lines[a], lines[b], step))
          found.corners.push_back(std::move(*corner));
  return found;
}

}  // namespace turgor::lattice::detail
