// Search of CCD on the host. A tree of motion boxes yields pairs of vertices that come near each other; all
// triangles and edges around such pairs are tested.
#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/ccd/ccd_zones.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

constexpr auto kLane = std::size_t(kLanes);
static_assert(kLeaf == 2 * kLane, "a leaf has two batches");
constexpr std::size_t kChunkSize = 4;  // leaves of a chunk

/// Motion box of sixteen vertices.
MotionBox box_of_batch(const Model& model, const CcdMotion& motion, std::size_t begin) {
  TURGOR_CHECK(begin < std::size_t(model.count), "a batch has a vertex");
  const int count = std::min(kLanes, model.count - int(begin));
  float numbers[7][kLanes];
  const Lanes3 x = load<Lanes>(motion.start, begin), d = load<Lanes>(motion.displacement, begin);
  const Lanes fields[7] = {x.x, x.y, x.z, d.x, d.y, d.z, load_lanes(&motion.longest2[begin])};
  // range of each number
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

MotionBox box_of_leaf(const Model& model, const CcdMotion& motion, std::size_t leaf) {
  const std::size_t begin = leaf * kLeaf, second = begin + kLane;
  const MotionBox box = box_of_batch(model, motion, begin);
  if (second >= std::size_t(model.count)) return box;
  return around(box, box_of_batch(model, motion, second));
}

/// Vertex with its incident triangles, except slivers, and its neighbors in these.
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

/// Collects the star of v. Triangles are stored with their smallest vertex, which is v or a smaller neighbor.
void gather_star(const Model& model, int v, Star& star) {
  TURGOR_CHECK(is_index(v, std::size_t(model.count)), "a star is around a vertex");
  if (star.vertex == v) return;
  star.vertex = v;
  star.triangles.clear(), star.neighbors.clear();
  const auto add_from = [&](int smallest) {
    for (int t = model.triangle_begin[std::size_t(smallest)];
         t < model.triangle_begin[std::size_t(smallest) + 1]; t++) {
      const Int3 corners = model.triangles[std::size_t(t)];
      if ((corners.x == v || corners.y == v || corners.z == v) && !model.membrane.is_sliver(std::size_t(t)))
        star.add(corners);
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

/// Vertices that move together: those of present zones, and those of pairs found in this search (union-find).
struct ZoneUnion {
  const CcdWorkspace& ccd;
  const ZoneOfVertex& zone;
  std::unordered_map<int, int> parent = {};

  int root(int v) const {
    if (!zone.empty() && zone[std::size_t(v)] >= 0) v = ccd.in_impact_zone[std::size_t(zone[std::size_t(v)])];
    for (auto next = parent.find(v); next != parent.end(); next = parent.find(v)) v = next->second;
    return v;
  }
  bool are_one(const std::array<int, 4>& v) const {
    const int first = root(v[0]);
    return root(v[1]) == first && root(v[2]) == first && root(v[3]) == first;
  }
  void join(const std::array<int, 4>& v) {
    for (std::size_t k = 1; k < 4; k++)
      if (const int a = root(v[0]), b = root(v[k]); a != b) parent[std::max(a, b)] = std::min(a, b);
  }
};

struct FindCcdPairs {
  const Model& model;
  const State& state;
  CcdMotion motion;
  double thickness;
  bool all;       // all pairs are visited
  bool list_all;  // pairs whose vertices are in one zone already are stored too
  const ZoneOfVertex& zone;
  std::vector<CcdPair>& found;
  ZoneUnion zones{state.ccd, zone};
  LinearMotion linear{motion.start, motion.displacement, view(model.x_rest), thickness};
  Star mine{}, other{};

  Vec3d position(int v) const { return linear.position(v); }
  Vec3d displacement(int v) const { return linear.displacement(v); }
  Real flatness(int v) const { return motion.flatness[v]; }

  /// True for i < j in a triangle whose smallest vertex is i. A cheap test that finds most edges.
  bool share_triangle(int i, int j) const {
    for (int t = model.triangle_begin[std::size_t(i)]; t < model.triangle_begin[std::size_t(i) + 1]; t++) {
      const Int3& corners = model.triangles[std::size_t(t)];
      if (corners.x == j || corners.y == j || corners.z == j) return true;
    }
    return false;
  }

  /// True if the stars unfold onto a plane and so cannot collide. Either the vertices are adjacent and their
  /// normals stay within 45°, hence within 90° of a shared triangle. Or they have a common neighbor and
  /// normals stay within 30°.
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
    for (const Int3& t : star.triangles)
      sum += cross(position(t.y) - position(t.x), position(t.z) - position(t.x));
    return sum;
  }
  /// Largest extent of a star along n during the motion, relative to a moving origin.
  double extent(const Star& star, Vec3d n, Vec3d origin, Vec3d origin_motion) const {
    double most = -INFINITY;
    const auto take = [&](int v) {
      const double at = dot(n, position(v) - origin);
      most = std::max({most, at, at + dot(n, displacement(v) - origin_motion)});
    };
    take(star.vertex);
    for (const int v : star.neighbors) take(v);
    return most;
  }
  /// True if a plane normal to one of the stars separates them during the motion, as for most stacked layers.
  bool are_separated() const {
    const Vec3d origin = position(mine.vertex), origin_motion = displacement(mine.vertex);
    for (const Star* star : {&mine, &other}) {
      Vec3d n = normal(*star);
      const double length = norm(n);
      if (!(length > 0)) continue;
      n *= (dot(n, position(other.vertex) - origin) < 0 ? -1 : 1) / length;
      if (extent(mine, n, origin, origin_motion) + extent(other, -n, origin, origin_motion) <
          -kClosest * thickness)
        return true;
    }
    return false;
  }

  /// Tests a vertex and a triangle, or two edges, and stores the pair if it collides.
  void test(const std::array<int, 4>& v, bool are_edges) {
    const LinearMotion::PrimitivePair primitives = linear.primitives(v, are_edges);
    if (!linear.may_collide(primitives)) return;
    if (!list_all && !found.empty() && zones.are_one(v)) return;
    if (!linear.collide(primitives, v)) return;
    found.push_back({v, are_edges});
    if (!list_all) zones.join(v);
  }

  /// True if this pair of vertices is certainly visited.
  bool are_visited(int i, int j) const {
    if (!all) return false;
    const Vec3d e = position(j) - position(i), f = displacement(j) - displacement(i);
    const double when = std::clamp(-dot(e, f) / std::max(dot(f, f), 1e-30), 0.0, 1.0);
    const Vec3d nearest = e + f * when;
    const auto longest2 = [&](int v) { return double(motion.longest2[v]); };
    return dot(nearest, nearest) < 0.49 * std::max(longest2(i), longest2(j));
  }
  /// Tests a primitive pair that several near vertices share with the first of these only.
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
    // flat or separated stars cannot collide
    if (flatness(i) >= 1 && flatness(j) >= 1 && share_triangle(i, j)) return;
    gather_star(model, i, mine), gather_star(model, j, other);
    if (unfold() || are_separated()) return;
    // vertices with triangles, then edges with edges
    for (const Int3& t : other.triangles)
      if (t.x != i && t.y != i && t.z != i && is_first(i, t, j)) test({i, t.x, t.y, t.z}, false);
    for (const Int3& t : mine.triangles)
      if (t.x != j && t.y != j && t.z != j && is_first(j, t, i)) test({j, t.x, t.y, t.z}, false);
    for (const int p : mine.neighbors)
      for (const int q : other.neighbors)
        if (p != j && q != i && p != q && is_first(i, p, j, q)) test({i, p, j, q}, true);
  }
};

/// Calls visit(i, j) for vertices i < j of two leaves that come within reach in the motion.
template <class Visit>
void visit_pairs(const Model& model, const CcdMotion& motion, std::size_t a, std::size_t b,
                 const MotionBox& box, const Visit& visit) {
  const int a_end = std::min(int((a + 1) * kLeaf), model.count),
            b_end = std::min(int((b + 1) * kLeaf), model.count);
  for (int i = int(a * kLeaf); i < a_end; i++) {
    const auto v = std::size_t(i);
    const Vec3 x = motion.start[v], d = motion.displacement[v];
    const Real mine2 = motion.longest2[v];
    // vertex against the box of the leaf
    if (!may_collide({x, x, d, d, reach_of(mine2)}, box)) continue;
    for (int begin = int(b * kLeaf); begin < b_end; begin += kLanes) {
      const auto w = std::size_t(begin);
      const Lanes3 xb = load<Lanes>(motion.start, w), db = load<Lanes>(motion.displacement, w);
      // smallest distance in the motion
      const Lanes3 e{xb.x - x.x, xb.y - x.y, xb.z - x.z}, f{db.x - d.x, db.y - d.y, db.z - d.z};
      const Lanes when =
          smaller(larger(-dot(e, f) / larger(dot(f, f), all_lanes(1e-30f)), all_lanes(0)), all_lanes(1));
      const Lanes3 nearest = e + f * when;
      const Lanes longest2 = larger(load_lanes(&motion.longest2[w]), all_lanes(mine2));
      unsigned hits = lanes_below(dot(nearest, nearest) - longest2 * 0.50001f, 0);
      for (; hits != 0; hits &= hits - 1) {
        const int j = begin + std::countr_zero(hits);
        if (j < b_end && (a != b || i < j)) visit(std::min(i, j), std::max(i, j));
      }
    }
  }
}

/// Calls visit(b) for the leaves from `first` on whose boxes may collide with that of leaf a. `skip`: tells
/// of a box whether it moves as one with leaf a.
template <class Skip, class Visit>
void visit_boxes(const CcdWorkspace& ccd, std::size_t a, std::size_t first, const Skip& skip,
                 const Visit& visit) {
  struct Node {
    std::size_t level, index;
  };
  std::array<Node, 64> stack;  // exceeds the depth of a binary tree
  std::size_t depth = 0;
  stack[depth++] = {ccd.level_begin.size() - 2, 0};
  TURGOR_CHECK(ccd.level_begin.size() >= 2 && a < ccd.boxes.size(), "every leaf has a box");
  const MotionBox mine = ccd.boxes[a];
  while (depth > 0) {
    const auto [level, index] = stack[--depth];
    if ((index + 1) << level <= first) continue;
    const std::size_t box = ccd.level_begin[level] + index;
    if (skip(box) || !may_collide(mine, ccd.boxes[box])) continue;
    if (level == 0) {
      visit(index);
      continue;
    }
    TURGOR_CHECK(depth + 2 <= stack.size(), "the stack holds a path to a leaf");
    const std::size_t below = ccd.level_begin[level] - ccd.level_begin[level - 1];
    if (2 * index + 1 < below) stack[depth++] = {level - 1, 2 * index + 1};
    stack[depth++] = {level - 1, 2 * index};
  }
}

bool any_changed(const CcdWorkspace& ccd, std::size_t leaf) {
  const auto begin = ccd.is_changed.begin() + std::ptrdiff_t(leaf * kLeaf);
  return std::find(begin, begin + kLeaf, 1) != begin + kLeaf;
}

}  // namespace

void build_boxes(const Exec& exec, const Model& model, State& state, bool changed) {
  // levels of the tree
  auto& boxes = state.ccd.boxes;
  auto& level_begin = state.ccd.level_begin;
  level_begin.assign(1, 0);
  for (std::size_t size = ccd_leaves(model);; size = (size + 1) / 2) {
    level_begin.push_back(level_begin.back() + size);
    if (size == 1) break;
  }
  boxes.resize(level_begin.back());
  // boxes of the leaves
  const CcdMotion motion = ccd_motion(view(model, state));
  parallel_for(
      exec, level_begin[1],
      [&](std::size_t leaf) {
        if (!changed || any_changed(state.ccd, leaf)) boxes[leaf] = box_of_leaf(model, motion, leaf);
      },
      64);
  // boxes of the upper levels
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

bool find_ccd_pairs(const Exec& exec, const Model& model, State& state, bool changed, bool list_all) {
  CcdWorkspace& ccd = state.ccd;
  const bool all = !changed;
  TURGOR_CHECK(!ccd.level_begin.empty() && ccd.boxes.size() == ccd.level_begin.back(),
               "the boxes of all levels are built");
  const CcdMotion motion = ccd_motion(view(model, state));
  const std::size_t count = ccd_leaves(model);
  // chunks of leaves
  ccd.chunk_pairs.resize((count + kChunkSize - 1) / kChunkSize);
  // impact zones of vertices, stars and boxes
  const ZoneOfVertex zone = changed ? zone_of_vertices(model, ccd) : ZoneOfVertex{},
                     of_star = changed ? zones_of_stars(exec, model, zone) : ZoneOfVertex{};
  const std::vector<int> of_box = changed ? zones_of_boxes(exec, model, ccd, of_star) : std::vector<int>{};
  const auto move_as_one = [&](int i, int j) {
    return of_star[std::size_t(i)] >= 0 && of_star[std::size_t(i)] == of_star[std::size_t(j)];
  };
  parallel_for(exec, ccd.chunk_pairs.size(), [&](std::size_t chunk) {
    ccd.chunk_pairs[chunk].clear();
    FindCcdPairs find{model, state,    motion, model.params.collision.thickness,
                      all,   list_all, zone,   ccd.chunk_pairs[chunk]};
    for (std::size_t a = chunk * kChunkSize; a < std::min((chunk + 1) * kChunkSize, count); a++) {
      if (!all && !any_changed(ccd, a)) continue;
      const auto moves_along = [&](std::size_t box) {
        return !all && of_box[a] >= 0 && of_box[box] == of_box[a];
      };
      visit_boxes(ccd, a, all ? a : 0, moves_along, [&](std::size_t b) {
        if (!all && b < a && any_changed(ccd, b)) return;  // b visits a
        visit_pairs(model, motion, a, b, ccd.boxes[b], [&](int i, int j) {
          if (all ||
              ((ccd.is_changed[std::size_t(i)] || ccd.is_changed[std::size_t(j)]) && !move_as_one(i, j)))
            find(i, j);
        });
      });
    }
  });
  // new pairs in the order of the chunks
  const std::size_t before = ccd.ccd_pairs.size();
  for (const auto& found : ccd.chunk_pairs)
    ccd.ccd_pairs.insert(ccd.ccd_pairs.end(), found.begin(), found.end());
  return ccd.ccd_pairs.size() > before;
}

}  // namespace turgor::cloth
