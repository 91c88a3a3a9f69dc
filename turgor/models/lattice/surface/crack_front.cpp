#include "turgor/models/lattice/surface/crack_front.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>

#include "turgor/core/key_index.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/surface/middle_of_sides.hpp"

namespace turgor::lattice::detail {

namespace {

constexpr Real kClosing = 1.25;  // height of the walls that close above a front [steps]
constexpr Real kNear = 1.5;      // distance of the points of a front [steps]
constexpr Real kRough = 0.15;    // largest mean distance of the points from a smooth line [steps]
constexpr Real kLip = 0.75;      // depth below the lips from which walls close entirely [steps]

/// Points in boxes, for the points within a radius of a position. A box is two radii wide.
class PointBoxes {
 public:
  PointBoxes(std::vector<Vec3> points, Real radius) : points_(std::move(points)), radius_(radius) {
    for (std::size_t n = 0; n < points_.size(); n++) {
      const int box = index_.find_or_add(key(box_of(points_[n])));
      if (std::size_t(box) == boxes_.size()) boxes_.emplace_back();
      boxes_[std::size_t(box)].push_back(int(n));
    }
  }
  /// Calls visit(index, offset from the position) for all points within the radius.
  template <class Visit>
  void for_near(Vec3 position, const Visit& visit) const {
    const Vec3 reach{radius_, radius_, radius_};
    const Int3 low = box_of(position - reach), high = box_of(position + reach);
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++) {
          const int n = index_.find(key({i, j, k}));
          if (n < 0) continue;
          for (const int p : boxes_[std::size_t(n)]) {
            const Vec3 away = points_[std::size_t(p)] - position;
            if (dot(away, away) < radius_ * radius_) visit(p, away);
          }
        }
  }
  Vec3 point(int n) const { return points_[std::size_t(n)]; }
  std::size_t size() const { return points_.size(); }

 private:
  Int3 box_of(Vec3 p) const {
    const Real size = 2 * radius_;
    return {int(std::floor(p.x / size)), int(std::floor(p.y / size)), int(std::floor(p.z / size))};
  }
  static std::uint64_t key(Int3 box) {
    constexpr int kMiddle = 1 << 20;
    return std::uint64_t(box.x + kMiddle) | std::uint64_t(box.y + kMiddle) << 21 |
           std::uint64_t(box.z + kMiddle) << 42;
  }
  std::vector<Vec3> points_;
  Real radius_;
  KeyIndex index_;
  std::vector<std::vector<int>> boxes_;
};

/// Groups of wall vertices that coincide at rest: the sides of a cut at one position.
struct Sides {
  FrontSides all;                      // its `opening` is empty
  int first_wall = 0;                  // first vertex of walls
  std::vector<int> of_vertex;          // by vertex from first_wall on: group, or -1
  std::vector<std::uint8_t> is_front;  // by group: on a crack front
  std::vector<Vec3> rest, normal;      // by group; the normal of one side

  int group(int vertex) const { return of_vertex[std::size_t(vertex - first_wall)]; }
};

/// Adds a vector or its opposite, whichever is longer then.
void add_aligned(Vec3 vector, Vec3& sum) { sum += dot(sum, vector) < 0 ? -vector : vector; }

bool is_same(const EmbeddingCell& a, const EmbeddingCell& b) {
  return a.cell == b.cell && a.fragment == b.fragment;
}

std::span<const Int3> walls_of(const BodySurface& surface) {
  return std::span(surface.triangles).subspan(std::size_t(surface.skin_triangles));
}

std::tuple<Real, Real, Real> coordinates(Vec3 p) { return {p.x, p.y, p.z}; }

/// Groups the vertices of walls.
Sides group_sides(const BodySurface& surface) {
  Sides sides;
  // vertices of walls
  const std::span<const Int3> wall = walls_of(surface);
  sides.first_wall = int(surface.rest.size());
  for (const Int3 t : wall) sides.first_wall = std::min({sides.first_wall, t.x, t.y, t.z});
  std::vector<int> order;
  for (int v = sides.first_wall; v < int(surface.rest.size()); v++) order.push_back(v);
  // sorted by position
  const auto key = [&](int v) { return std::pair(coordinates(surface.rest[std::size_t(v)]), v); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  // groups of at least two
  sides.of_vertex.assign(order.size(), -1);
  for (std::size_t a = 0, b = 0; a < order.size(); a = b) {
    const Vec3 rest = surface.rest[std::size_t(order[a])];
    while (b < order.size() && surface.rest[std::size_t(order[b])] == rest) b++;
    if (b - a < 2) continue;
    for (std::size_t n = a; n < b; n++) {
      sides.of_vertex[std::size_t(order[n] - sides.first_wall)] = int(sides.rest.size());
      sides.all.vertices.push_back(order[n]);
    }
    sides.all.begin.push_back(int(sides.all.vertices.size()));
    sides.rest.push_back(rest);
  }
  return sides;
}

/// Positions of the lips at rest, sorted.
std::vector<Vec3> sorted_lips(const BodySurface& surface) {
  std::vector<Vec3> lips;
  for (const Lip& lip : surface.lips) lips.push_back(surface.rest[std::size_t(lip.left)]);
  std::sort(lips.begin(), lips.end(), [](Vec3 a, Vec3 b) { return coordinates(a) < coordinates(b); });
  return lips;
}

/// Marks the groups on crack fronts: a triangle with both sides of a cut has no area at rest and ends the
/// walls. On lips, points of one side may coincide.
void mark_fronts(const BodySurface& surface, const std::vector<Vec3>& lips, Sides& sides) {
  sides.is_front.resize(sides.rest.size());
  for (const Int3 t : walls_of(surface))
    for (int c = 0; c < 3; c++) {
      const int v = t[c], next = t[(c + 1) % 3], g = sides.group(v);
      if (g < 0 || g != sides.group(next)) continue;
      const bool is_lip = std::binary_search(lips.begin(), lips.end(), sides.rest[std::size_t(g)],
                                             [](Vec3 a, Vec3 b) { return coordinates(a) < coordinates(b); });
      if (!is_lip && !is_same(surface.embedding[std::size_t(v)], surface.embedding[std::size_t(next)]))
        sides.is_front[std::size_t(g)] = 1;
    }
}

/// Finds the normals of the walls.
void find_normals(const BodySurface& surface, Sides& sides) {
  // sums of areas
  sides.normal.resize(sides.rest.size());
  for (const Int3 t : walls_of(surface)) {
    const Vec3 a = surface.rest[std::size_t(t.x)];
    const Vec3 area = cross(surface.rest[std::size_t(t.y)] - a, surface.rest[std::size_t(t.z)] - a);
    for (int c = 0; c < 3; c++)
      if (const int g = sides.group(t[c]); g >= 0) add_aligned(area, sides.normal[std::size_t(g)]);
  }
  // normals of slivers are those of the triangles around them
  const std::vector<Vec3> own = sides.normal;
  for (const Int3 t : walls_of(surface))
    for (int c = 0; c < 3; c++) {
      const int g = sides.group(t[c]), next = sides.group(t[(c + 1) % 3]);
      if (g < 0 || next < 0) continue;
      add_aligned(own[std::size_t(next)], sides.normal[std::size_t(g)]);
      add_aligned(own[std::size_t(g)], sides.normal[std::size_t(next)]);
    }
  for (Vec3& normal : sides.normal) normal = normalized(normal);
}

/// Groups on crack fronts.
std::vector<int> front_groups(const Sides& sides) {
  std::vector<int> groups;
  for (std::size_t g = 0; g < sides.rest.size(); g++)
    if (sides.is_front[g]) groups.push_back(int(g));
  return groups;
}
std::vector<Vec3> chosen(const std::vector<Vec3>& all, const std::vector<int>& groups) {
  std::vector<Vec3> some;
  for (const int g : groups) some.push_back(all[std::size_t(g)]);
  return some;
}

/// True if a wall with a normal continues that of another point.
bool is_same_wall(Vec3 normal, Vec3 other, Vec3 away) {
  constexpr Real kParallel = 0.8, kBeside = 0.4;  // cosine and sine of the largest angles
  return std::abs(dot(normal, other)) > kParallel && std::abs(dot(away, normal)) <= kBeside * norm(away);
}

/// Drops the points of fronts that have few others around them, as where a single fine edge is not cut.
void drop_lone_fronts(Sides& sides, Real reach) {
  constexpr int kFewest = 4;
  const std::vector<int> groups = front_groups(sides);
  const PointBoxes points(chosen(sides.rest, groups), reach);
  for (std::size_t f = 0; f < groups.size(); f++) {
    int others = -1;
    points.for_near(points.point(int(f)), [&](int n, Vec3 away) {
      others += is_same_wall(sides.normal[std::size_t(groups[f])],
                             sides.normal[std::size_t(groups[std::size_t(n)])], away);
    });
    if (others < kFewest) sides.is_front[std::size_t(groups[f])] = 0;
  }
}

/// 3 t² − 2 t³, clamped to t from 0 to 1.
Real smooth_step(Real t) {
  t = std::clamp(t, Real(0), Real(1));
  return t * t * (3 - 2 * t);
}

/// Points of all crack fronts. They lie up to a fine edge above or below a smooth line.
class Fronts {
 public:
  Fronts(const Sides& sides, Real reach) : Fronts(sides, reach, front_groups(sides)) {}

  std::size_t size() const { return normal_.size(); }
  /// Height of a point of a wall above the front near it [m]: above a smooth line through the front, raised
  /// by twice the mean distance of the front's points from it. Empty away from fronts.
  std::optional<Real> height(Vec3 at, Vec3 normal) const {
    const auto line = line_near(at, normal);
    if (!line) return {};
    return line->height - 2 * std::min(line->roughness, kRough * reach_ / kNear);
  }

 private:
  struct Line {
    Real height = 0;     // of the position above it [m]
    Real roughness = 0;  // mean distance of its points from it [m]
  };
  Fronts(const Sides& sides, Real reach, const std::vector<int>& groups)
      : reach_(reach), points_(chosen(sides.rest, groups), reach), normal_(chosen(sides.normal, groups)) {
    // mean direction to the points of the wall
    const PointBoxes wall(sides.rest, reach);
    for (std::size_t f = 0; f < size(); f++) {
      Vec3 sum;
      wall.for_near(points_.point(int(f)), [&](int g, Vec3 away) {
        if (is_same_wall(normal_[f], sides.normal[std::size_t(g)], away)) sum += away * weight(away);
      });
      into_.push_back(normalized(sum));
    }
    // distances from the smooth line
    distance_.assign(size(), 0);
    std::vector<Real> distance;
    for (std::size_t f = 0; f < size(); f++)
      distance.push_back(std::abs(line_near(points_.point(int(f)), normal_[f]).value_or(Line{}).height));
    distance_ = std::move(distance);
  }

  Real weight(Vec3 away) const {
    const Real t = 1 - dot(away, away) / (reach_ * reach_);
    return t * t;
  }
  std::optional<Line> line_near(Vec3 at, Vec3 normal) const {
    Real total = 0, distance = 0;
    Vec3 sum, into;
    points_.for_near(at, [&](int f, Vec3 away) {
      if (!is_same_wall(normal, normal_[std::size_t(f)], away)) return;
      const Real w = weight(away);
      total += w, sum += away * w, into += into_[std::size_t(f)] * w,
          distance += distance_[std::size_t(f)] * w;
    });
    if (!(total > 0)) return {};
    return Line{-dot(sum, normalized(into)) / total, distance / total};
  }

  Real reach_;  // [m]
  PointBoxes points_;
  std::vector<Vec3> normal_, into_;
  std::vector<Real> distance_;  // from the smooth line [m]
};

/// Adds the vertices without another side that have neighbors near fronts.
void add_lone_vertices(const BodySurface& surface, const Sides& sides, FrontSides& near) {
  // vertices that move, and pairs of a lone vertex and a neighbor with sides
  std::vector<std::uint8_t> moves(sides.of_vertex.size());
  for (const int v : near.vertices) moves[std::size_t(v - sides.first_wall)] = 1;
  std::vector<std::pair<int, int>> pairs;
  for (const Int3 t : walls_of(surface))
    for (int c = 0; c < 3; c++)
      for (const int other : {t[(c + 1) % 3], t[(c + 2) % 3]})
        if (sides.group(t[c]) < 0 && sides.group(other) >= 0) pairs.emplace_back(t[c], other);
  sort_unique(pairs);
  // neighbors of each
  for (std::size_t a = 0, b = 0; a < pairs.size(); a = b) {
    bool any_moves = false;
    for (; b < pairs.size() && pairs[b].first == pairs[a].first; b++)
      any_moves |= moves[std::size_t(pairs[b].second - sides.first_wall)] != 0;
    if (!any_moves) continue;
    near.lone.push_back(pairs[a].first);
    for (std::size_t n = a; n < b; n++) near.beside.push_back(pairs[n].second);
    near.beside_begin.push_back(int(near.beside.size()));
  }
}

}  // namespace

FrontSides find_front_sides(const BodySurface& surface, Real step) {
  // fronts and lips
  Sides sides = group_sides(surface);
  std::vector<Vec3> skin = sorted_lips(surface);
  mark_fronts(surface, skin, sides);
  find_normals(surface, sides);
  drop_lone_fronts(sides, kNear * step);
  const Fronts fronts(sides, kNear * step);
  if (fronts.size() == 0) return {};
  const PointBoxes lips(std::move(skin), kLip * step);
  // sides near fronts
  FrontSides near;
  for (std::size_t g = 0; g < sides.rest.size(); g++) {
    // height above the front, and depth below the lips
    const std::optional<Real> height =
        sides.is_front[g] ? Real(0) : fronts.height(sides.rest[g], sides.normal[g]);
    if (!height || !(*height < kClosing * step)) continue;
    Real depth = kLip * step;
    lips.for_near(sides.rest[g], [&](int, Vec3 away) { depth = std::min(depth, norm(away)); });
    const Real closed = (1 - smooth_step(*height / (kClosing * step))) * smooth_step(depth / (kLip * step));
    if (!(closed > 0)) continue;
    for (int n = sides.all.begin[g]; n < sides.all.begin[g + 1]; n++)
      near.vertices.push_back(sides.all.vertices[std::size_t(n)]);
    near.begin.push_back(int(near.vertices.size()));
    near.opening.push_back(1 - closed);
  }
  add_lone_vertices(surface, sides, near);
  return near;
}

void close_fronts(const FrontSides& sides, std::vector<Vec3>& x) {
  std::vector<Vec3> before;
  for (const int v : sides.beside) before.push_back(x[std::size_t(v)]);
  // both sides toward their middle
  for (std::size_t g = 0; g < sides.opening.size(); g++) {
    const auto begin = std::size_t(sides.begin[g]), end = std::size_t(sides.begin[g + 1]);
    const auto group = std::span(sides.vertices).subspan(begin, end - begin);
    const Vec3 middle = middle_of_sides(group, x);
    for (const int v : group) x[std::size_t(v)] = middle + (x[std::size_t(v)] - middle) * sides.opening[g];
  }
  // a lone vertex with its neighbors
  for (std::size_t n = 0; n < sides.lone.size(); n++) {
    const auto begin = std::size_t(sides.beside_begin[n]), end = std::size_t(sides.beside_begin[n + 1]);
    Vec3 sum;
    for (std::size_t b = begin; b < end; b++) sum += x[std::size_t(sides.beside[b])] - before[b];
    x[std::size_t(sides.lone[n])] += sum / Real(end - begin);
  }
}

}  // namespace turgor::lattice::detail
