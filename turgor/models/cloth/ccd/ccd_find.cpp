// Where triangles or edges could meet in a step: boxes that hold places and displacements of sixteen vertices
// each, in a tree, lead to pairs of vertices that come near; around these, all is tested.
#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

namespace {

constexpr auto kLane = std::size_t(kLanes);
constexpr std::size_t kLeaf = 2 * kLane;  // vertices in the smallest boxes
constexpr std::size_t kPiece = 4;         // such boxes that are looked at as one piece

std::size_t leaves_of(const Model& model) { return (std::size_t(model.count) + kLeaf - 1) / kLeaf; }

MotionBox box_of_batch(const Model& model, const System& system, std::size_t begin) {
  const int count = std::min(kLanes, model.count - int(begin));
  float numbers[7][kLanes];
  const Lanes3 x = load(system.before, begin), d = load(system.force, begin);
  const Lanes fields[7] = {x.x, x.y, x.z, d.x, d.y, d.z, load_lanes(&system.inverse[0].x[begin])};
  float low[7], high[7];
  for (int f = 0; f < 7; f++) {
    store_lanes(numbers[f], fields[f]);
    const auto [least, most] = std::minmax_element(numbers[f], numbers[f] + count);
    low[f] = *least, high[f] = *most;
  }
  return {{low[0], low[1], low[2]},
          {high[0], high[1], high[2]},
          {low[3], low[4], low[5]},
          {high[3], high[4], high[5]},
          reach_of(high[6])};
}

MotionBox box_of_leaf(const Model& model, const System& system, std::size_t leaf) {
  const std::size_t begin = leaf * kLeaf, second = begin + kLane;
  const MotionBox box = box_of_batch(model, system, begin);
  if (second >= std::size_t(model.count)) return box;
  return around(box, box_of_batch(model, system, second));
}

/// A vertex with the triangles around it.
struct Star {
  int vertex = -1;
  std::vector<Int3> triangles;
  std::vector<int> neighbors;

  void add(const Int3& t) {
    triangles.push_back(t);
    for (int k = 0; k < 3; k++)
      if (t[k] != vertex && std::find(neighbors.begin(), neighbors.end(), t[k]) == neighbors.end())
        neighbors.push_back(t[k]);
  }
  bool has(int v) const { return std::find(neighbors.begin(), neighbors.end(), v) != neighbors.end(); }
};

/// Triangles are in the order of their smallest vertices: those of v itself and of smaller ones that springs
/// join to it.
void gather_star(const Model& model, int v, Star& star) {
  if (star.vertex == v) return;
  star.vertex = v;
  star.triangles.clear(), star.neighbors.clear();
  const auto add_from = [&](int smallest) {
    for (int t = model.triangle_begin[std::size_t(smallest)];
         t < model.triangle_begin[std::size_t(smallest) + 1]; t++) {
      const Int3 corners = model.triangles[std::size_t(t)];
      if (corners.x == v || corners.y == v || corners.z == v) star.add(corners);
    }
  };
  const Rows& rows = model.rows;
  const std::size_t batch = std::size_t(v) / kLane, lane = std::size_t(v) % kLane;
  for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
    const std::size_t entry = std::size_t(s) * kLane + lane;
    if (!((rows.rest.empty() ? rows.stiffness : rows.rest)[entry] > 0)) continue;
    const int first = rows.first[std::size_t(s)];
    const int other = first >= 0 ? first + int(lane) : rows.gathered[std::size_t(-1 - first) + lane];
    if (other < v) add_from(other);
  }
  add_from(v);
}

/// What moves as one already, or will because of what was found.
struct Joined {
  const CcdWorkspace& ccd;
  std::unordered_map<int, int> into;

  int root(int v) const {
    const auto& [in_impact_zone, zone] = std::tie(ccd.in_impact_zone, ccd.zone);
    const auto at = std::lower_bound(in_impact_zone.begin(), in_impact_zone.end(), v);
    if (at != in_impact_zone.end() && *at == v)
      v = in_impact_zone[std::size_t(zone[std::size_t(at - in_impact_zone.begin())])];
    for (auto next = into.find(v); next != into.end(); next = into.find(v)) v = next->second;
    return v;
  }
  bool are_one(const std::array<int, 4>& v) const {
    const int first = root(v[0]);
    return root(v[1]) == first && root(v[2]) == first && root(v[3]) == first;
  }
  void join(const std::array<int, 4>& v) {
    for (std::size_t k = 1; k < 4; k++)
      if (const int a = root(v[0]), b = root(v[k]); a != b) into[std::max(a, b)] = std::min(a, b);
  }
};

struct FindCcdPairs {
  const Model& model;
  const State& state;
  const System& system;
  double thickness;
  bool all;  // pairs of vertices are looked at
  std::vector<CcdPair>& found;
  Joined joined{state.ccd};
  Ways ways{view(system.before), view(system.force), view(model.x_rest), thickness};
  Star mine{}, other{};

  Vec3d place(int v) const { return ways.place(v); }
  Vec3d way(int v) const { return ways.way(v); }
  Real flatness(int v) const { return system.inverse[0].y[std::size_t(v)]; }

  /// i < j in one triangle that has no smaller vertex: finds most edges at little cost.
  bool are_joined(int i, int j) const {
    for (int t = model.triangle_begin[std::size_t(i)]; t < model.triangle_begin[std::size_t(i) + 1]; t++) {
      const Int3& corners = model.triangles[std::size_t(t)];
      if (corners.x == j || corners.y == j || corners.z == j) return true;
    }
    return false;
  }

  /// Adjacent vertices whose normals stay within 45°, so within 90° of a triangle they share: all around them
  /// unfolds onto its plane. So it does within 30° with a neighbour in common.
  bool unfold() const {
    const Real flattest = std::min(flatness(mine.vertex), flatness(other.vertex));
    if (mine.has(other.vertex)) return flattest >= 1;
    if (flattest < 2) return false;
    for (const int v : mine.neighbors)
      if (flatness(v) >= 2 && other.has(v)) return true;
    return false;
  }

  Vec3d normal(const Star& star) const {
    Vec3d sum;
    for (const Int3& t : star.triangles) sum += cross(place(t.y) - place(t.x), place(t.z) - place(t.x));
    return sum;
  }
  /// How far along n the star reaches, at most, on its way from where its vertex is.
  double extent(const Star& star, Vec3d n, Vec3d origin, Vec3d drift) const {
    double most = -INFINITY;
    const auto take = [&](int v) {
      const double at = dot(n, place(v) - origin);
      most = std::max({most, at, at + dot(n, way(v) - drift)});
    };
    take(star.vertex);
    for (const int v : star.neighbors) take(v);
    return most;
  }
  /// Most layers that lie on each other are parted by a plane across the normal of one of them.
  bool are_parted() const {
    const Vec3d origin = place(mine.vertex), drift = way(mine.vertex);
    for (const Star* star : {&mine, &other}) {
      Vec3d n = normal(*star);
      const double length = norm(n);
      if (!(length > 0)) continue;
      n *= (dot(n, place(other.vertex) - origin) < 0 ? -1 : 1) / length;
      if (extent(mine, n, origin, drift) + extent(other, -n, origin, drift) < -kClosest * thickness)
        return true;
    }
    return false;
  }

  void test(const std::array<int, 4>& v, bool are_edges) {
    const Ways::Four four = ways.four(v, are_edges);
    if (!ways.may_meet(four)) return;
    if (!found.empty() && joined.are_one(v)) return;
    if (!ways.meet(four, v)) return;
    found.push_back({v, are_edges});
    joined.join(v);
  }

  /// Whether these vertices are visited together for sure.
  bool are_visited(int i, int j) const {
    if (!all) return false;
    const Vec3d e = place(j) - place(i), f = way(j) - way(i);
    const double when = std::clamp(-dot(e, f) / std::max(dot(f, f), 1e-30), 0.0, 1.0);
    const Vec3d nearest = e + f * when;
    const auto longest2 = [&](int v) { return double(system.inverse[0].x[std::size_t(v)]); };
    return dot(nearest, nearest) < 0.49 * std::max(longest2(i), longest2(j));
  }
  /// Things that have several pairs of near vertices are tested with the first pair only.
  bool is_first(int v, const Int3& t, int corner) const {
    for (int k = 0; k < 3; k++)
      if (t[k] < corner && are_visited(v, t[k])) return false;
    return true;
  }
  bool is_first(int i, int p, int j, int q) const {
    const std::pair<int, int> this_one = std::minmax(i, j);
    for (const auto& [a, b] : {std::pair(i, q), std::pair(p, j), std::pair(p, q)})
      if (std::pair<int, int>(std::minmax(a, b)) < this_one && are_visited(a, b)) return false;
    return true;
  }

  void operator()(int i, int j) {
    if (flatness(i) >= 1 && flatness(j) >= 1 && are_joined(i, j)) return;
    gather_star(model, i, mine), gather_star(model, j, other);
    if (unfold() || are_parted()) return;
    for (const Int3& t : other.triangles)
      if (t.x != i && t.y != i && t.z != i && is_first(i, t, j)) test({i, t.x, t.y, t.z}, false);
    for (const Int3& t : mine.triangles)
      if (t.x != j && t.y != j && t.z != j && is_first(j, t, i)) test({j, t.x, t.y, t.z}, false);
    for (const int p : mine.neighbors)
      for (const int q : other.neighbors)
        if (p != j && q != i && p != q && is_first(i, p, j, q)) test({i, p, j, q}, true);
  }
};

/// Pairs of vertices i < j of two leaves that come within reach on their way.
template <class Visit>
void visit_pairs(const Model& model, const System& system, std::size_t a, std::size_t b, const MotionBox& box,
                 const Visit& visit) {
  const int a_end = std::min(int((a + 1) * kLeaf), model.count),
            b_end = std::min(int((b + 1) * kLeaf), model.count);
  for (int i = int(a * kLeaf); i < a_end; i++) {
    const auto v = std::size_t(i);
    const Vec3 x = system.before[v], d = system.force[v];
    const Real mine2 = system.inverse[0].x[v];
    if (!may_meet({x, x, d, d, reach_of(mine2)}, box)) continue;
    for (int begin = int(b * kLeaf); begin < b_end; begin += kLanes) {
      const auto w = std::size_t(begin);
      const Lanes3 xb = load(system.before, w), db = load(system.force, w);
      const Lanes3 e{xb.x - x.x, xb.y - x.y, xb.z - x.z}, f{db.x - d.x, db.y - d.y, db.z - d.z};
      const Lanes when =
          smaller(larger(-dot(e, f) / larger(dot(f, f), all_lanes(1e-30f)), all_lanes(0)), all_lanes(1));
      const Lanes3 nearest = e + f * when;
      const Lanes longest2 = larger(load_lanes(&system.inverse[0].x[w]), all_lanes(mine2));
      unsigned hits = lanes_below(dot(nearest, nearest) - longest2 * 0.50001f, 0);
      for (; hits != 0; hits &= hits - 1) {
        const int j = begin + std::countr_zero(hits);
        if (j < b_end && (a != b || i < j)) visit(std::min(i, j), std::max(i, j));
      }
    }
  }
}

/// Calls visit(b) for the leaves from `first` on whose boxes may meet that of leaf a.
template <class Visit>
void visit_boxes(const CcdWorkspace& ccd, std::size_t a, std::size_t first, const Visit& visit) {
  struct Node {
    std::size_t level, index;
  };
  std::array<Node, 64> stack;  // deeper than any tree of halves
  std::size_t depth = 0;
  stack[depth++] = {ccd.level_begin.size() - 2, 0};
  const MotionBox mine = ccd.boxes[a];
  while (depth > 0) {
    const auto [level, index] = stack[--depth];
    if ((index + 1) << level <= first) continue;
    if (!may_meet(mine, ccd.boxes[ccd.level_begin[level] + index])) continue;
    if (level == 0) {
      visit(index);
      continue;
    }
    const std::size_t below = ccd.level_begin[level] - ccd.level_begin[level - 1];
    if (2 * index + 1 < below) stack[depth++] = {level - 1, 2 * index + 1};
    stack[depth++] = {level - 1, 2 * index};
  }
}

/// Marks the vertices around which something moves in another way: what is caught, and its neighbours. What a
/// caught vertex meets may lie nearer to a neighbour than to itself.
void mark_changed(const Model& model, CcdWorkspace& ccd) {
  ccd.is_changed.assign(leaves_of(model) * kLeaf, 0);
  Star star;
  for (const int v : ccd.in_impact_zone) {
    gather_star(model, v, star);
    ccd.is_changed[std::size_t(v)] = 1;
    for (const int other : star.neighbors) ccd.is_changed[std::size_t(other)] = 1;
  }
}

bool any_changed(const CcdWorkspace& ccd, std::size_t leaf) {
  const auto begin = ccd.is_changed.begin() + std::ptrdiff_t(leaf * kLeaf);
  return std::find(begin, begin + kLeaf, 1) != begin + kLeaf;
}

}  // namespace

void place_boxes(const Exec& exec, const Model& model, State& state) {
  auto& boxes = state.ccd.boxes;
  auto& level_begin = state.ccd.level_begin;
  level_begin.assign(1, 0);
  for (std::size_t size = leaves_of(model);; size = (size + 1) / 2) {
    level_begin.push_back(level_begin.back() + size);
    if (size == 1) break;
  }
  boxes.resize(level_begin.back());
  parallel_for(
      exec, level_begin[1], [&](std::size_t leaf) { boxes[leaf] = box_of_leaf(model, state.system, leaf); },
      64);
  for (std::size_t level = 1; level + 1 < level_begin.size(); level++) {
    const std::size_t below = level_begin[level - 1], begin = level_begin[level];
    parallel_for(
        exec, level_begin[level + 1] - begin,
        [&](std::size_t n) {
          const std::size_t first = below + 2 * n;
          boxes[begin + n] = first + 1 < begin ? around(boxes[first], boxes[first + 1]) : boxes[first];
        },
        256);
  }
}

bool find_ccd_pairs(const Exec& exec, const Model& model, State& state, bool all) {
  CcdWorkspace& ccd = state.ccd;
  const std::size_t count = leaves_of(model);
  ccd.found.resize((count + kPiece - 1) / kPiece);
  if (!all) mark_changed(model, ccd);
  parallel_for(exec, ccd.found.size(), [&](std::size_t piece) {
    ccd.found[piece].clear();
    FindCcdPairs find{model, state, state.system, model.params.collision.thickness, all, ccd.found[piece]};
    for (std::size_t a = piece * kPiece; a < std::min((piece + 1) * kPiece, count); a++) {
      if (!all && !any_changed(ccd, a)) continue;
      visit_boxes(ccd, a, all ? a : 0, [&](std::size_t b) {
        if (!all && b < a && any_changed(ccd, b)) return;  // b looks at a
        visit_pairs(model, state.system, a, b, ccd.boxes[b], [&](int i, int j) {
          if (all || ccd.is_changed[std::size_t(i)] || ccd.is_changed[std::size_t(j)]) find(i, j);
        });
      });
    }
  });
  const std::size_t before = ccd.ccd_pairs.size();
  for (const auto& found : ccd.found) ccd.ccd_pairs.insert(ccd.ccd_pairs.end(), found.begin(), found.end());
  return ccd.ccd_pairs.size() > before;
}

}  // namespace turgor::cloth
