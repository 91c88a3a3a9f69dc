// Where triangles or edges could meet in a step: boxes that hold places and displacements of sixteen vertices
// each, in a tree, lead to pairs of vertices that come near; around these, all is tested.
#include <algorithm>
#include <bit>
#include <cmath>

#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/crossing.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kBatches = 8;  // that are looked at as one piece
constexpr auto kLane = std::size_t(kLanes);

std::size_t batches_of(const Model& model) { return padded(std::size_t(model.count)) / kLane; }

/// Two edges that cross have ends nearer than √½ of the longer one; a point of a triangle is nearer to a
/// corner.
Real reach_of(Real longest2) { return std::sqrt(Real(0.50001) * longest2); }

MotionBox box_of_batch(const Model& model, const System& system, std::size_t batch) {
  const std::size_t i = batch * kLane;
  const int count = std::min(kLanes, model.count - int(i));
  float numbers[7][kLanes];
  const Lanes3 x = load(system.before, i), d = load(system.force, i);
  const Lanes longest2 = load_lanes(&system.inverse[0].x[i]);
  const Lanes fields[7] = {x.x, x.y, x.z, d.x, d.y, d.z, longest2};
  MotionBox box;
  float low[6], high[7];
  for (int f = 0; f < 7; f++) {
    store_lanes(numbers[f], fields[f]);
    const auto [least, most] = std::minmax_element(numbers[f], numbers[f] + count);
    if (f < 6) low[f] = *least;
    high[f] = *most;
  }
  box.low = {low[0], low[1], low[2]}, box.high = {high[0], high[1], high[2]};
  box.least = {low[3], low[4], low[5]}, box.most = {high[3], high[4], high[5]};
  box.reach = reach_of(high[6]);
  return box;
}

MotionBox around(const MotionBox& a, const MotionBox& b) {
  return {min(a.low, b.low), max(a.high, b.high), min(a.least, b.least), max(a.most, b.most),
          std::max(a.reach, b.reach)};
}

/// Whether anything in a and b may come nearer than the reach, seen along each axis.
inline bool may_meet(const MotionBox& a, const MotionBox& b) {
  const Real reach = std::max(a.reach, b.reach);
  for (int k = 0; k < 3; k++) {
    const Real low = b.low[k] - a.high[k] - reach + std::min(Real(0), b.least[k] - a.most[k]);
    const Real high = b.high[k] - a.low[k] + reach + std::max(Real(0), b.most[k] - a.least[k]);
    if (low > 0 || high < 0) return false;
  }
  return true;
}

/// A vertex with the triangles around it.
struct Star {
  int vertex = -1;
  std::vector<Int3> triangles;
  std::vector<int> neighbours;

  void add(const Int3& t) {
    triangles.push_back(t);
    for (int k = 0; k < 3; k++)
      if (t[k] != vertex && std::find(neighbours.begin(), neighbours.end(), t[k]) == neighbours.end())
        neighbours.push_back(t[k]);
  }
  bool has(int v) const { return std::find(neighbours.begin(), neighbours.end(), v) != neighbours.end(); }
};

/// Triangles are in the order of their smallest vertices: those of v itself and of smaller ones that springs
/// join to it.
void gather_star(const Model& model, int v, Star& star) {
  if (star.vertex == v) return;
  star.vertex = v;
  star.triangles.clear(), star.neighbours.clear();
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
    if (!(rows.rest[std::size_t(s) * kLane + lane] > 0)) continue;
    const int first = rows.first[std::size_t(s)];
    const int other = first >= 0 ? first + int(lane) : rows.gathered[std::size_t(-1 - first) + lane];
    if (other < v) add_from(other);
  }
  add_from(v);
}

struct FindMeetings {
  const Model& model;
  const State& state;
  const System& system;
  double thickness;
  std::vector<Meeting>& found;
  Star mine{}, other{};

  Vec3d place(int v) const { return Vec3d(system.before[std::size_t(v)]); }
  Vec3d way(int v) const { return Vec3d(system.force[std::size_t(v)]); }
  bool is_flat(int v) const { return system.inverse[0].y[std::size_t(v)] > 0; }

  /// i < j in one triangle that has no smaller vertex: finds most edges at little cost.
  bool are_joined(int i, int j) const {
    for (int t = model.triangle_begin[std::size_t(i)]; t < model.triangle_begin[std::size_t(i) + 1]; t++) {
      const Int3& corners = model.triangles[std::size_t(t)];
      if (corners.x == j || corners.y == j || corners.z == j) return true;
    }
    return false;
  }

  /// Two flat vertices that are adjacent or have a flat neighbour in common: all around them unfolds onto a
  /// plane.
  bool unfold() const {
    if (!is_flat(mine.vertex) || !is_flat(other.vertex)) return false;
    if (mine.has(other.vertex)) return true;
    for (const int v : mine.neighbours)
      if (is_flat(v) && other.has(v)) return true;
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
    for (const int v : star.neighbours) take(v);
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

  /// Whether a plane across one of the axes parts them all the way.
  static bool are_parted_by_axis(const std::array<Vec3d, 4>& x, const std::array<Vec3d, 4>& d, int first,
                                 double margin) {
    for (int k = 0; k < 3; k++) {
      double low[2]{INFINITY, INFINITY}, high[2]{-INFINITY, -INFINITY};
      for (int n = 0; n < 4; n++) {
        const double from = x[std::size_t(n)][k], to = from + d[std::size_t(n)][k];
        const int side = n < first ? 0 : 1;
        low[side] = std::min({low[side], from, to}), high[side] = std::max({high[side], from, to});
      }
      if (low[0] > high[1] + margin || low[1] > high[0] + margin) return true;
    }
    return false;
  }

  void test(const std::array<int, 4>& v, bool are_edges) {
    std::array<Vec3d, 4> x, d;
    bool moves_as_one = true;
    for (std::size_t k = 0; k < 4; k++) {
      x[k] = place(v[k]), d[k] = way(v[k]) - way(v[0]);
      moves_as_one = moves_as_one && d[k] == Vec3d{};
    }
    if (moves_as_one || are_parted_by_axis(x, d, are_edges ? 2 : 1, kClosest * thickness)) return;
    if (comes_too_near(x, d, are_edges, thickness)) found.push_back({v, are_edges});
  }

  void operator()(int i, int j) {
    if (is_flat(i) && is_flat(j) && are_joined(i, j)) return;
    gather_star(model, i, mine), gather_star(model, j, other);
    if (unfold() || are_parted()) return;
    for (const Int3& t : other.triangles)
      if (t.x != i && t.y != i && t.z != i) test({i, t.x, t.y, t.z}, false);
    for (const Int3& t : mine.triangles)
      if (t.x != j && t.y != j && t.z != j) test({j, t.x, t.y, t.z}, false);
    for (const int p : mine.neighbours)
      for (const int q : other.neighbours)
        if (p != j && q != i && p != q) test({i, p, j, q}, true);
  }
};

/// Pairs of vertices of two batches that come within reach on their way.
template <class Visit>
void visit_pairs(const Model& model, const System& system, std::size_t a, std::size_t b, const MotionBox& box,
                 const Visit& visit) {
  const std::size_t begin = b * kLane;
  const unsigned exist = (2u << (std::min(kLanes, model.count - int(begin)) - 1)) - 1;
  const Lanes3 xb = load(system.before, begin), db = load(system.force, begin);
  const Lanes longest2 = load_lanes(&system.inverse[0].x[begin]);
  const int end = std::min(int((a + 1) * kLane), model.count);
  for (int i = int(a * kLane); i < end; i++) {
    const auto v = std::size_t(i);
    const Vec3 x = system.before[v], d = system.force[v];
    const Real mine2 = system.inverse[0].x[v];
    if (!may_meet({x, x, d, d, reach_of(mine2)}, box)) continue;
    const Lanes3 e{xb.x - x.x, xb.y - x.y, xb.z - x.z}, f{db.x - d.x, db.y - d.y, db.z - d.z};
    const Lanes when =
        smaller(larger(-dot(e, f) / larger(dot(f, f), all_lanes(1e-30f)), all_lanes(0)), all_lanes(1));
    const Lanes3 nearest = e + f * when;
    unsigned hits =
        exist & lanes_below(dot(nearest, nearest) - larger(longest2, all_lanes(mine2)) * 0.50001f, 0);
    if (a == b) hits &= ~((2u << (i - int(begin))) - 1);
    for (; hits != 0; hits &= hits - 1) visit(i, int(begin) + std::countr_zero(hits));
  }
}

/// Calls visit(b) for the batches from `first` on whose boxes may meet that of batch a.
template <class Visit>
void visit_boxes(const std::vector<MotionBox>& boxes, std::size_t a, std::size_t first, std::size_t count,
                 const Visit& visit) {
  const std::size_t leaves = boxes.size() / 2;
  struct Node {
    std::size_t index, begin, size;
  };
  std::array<Node, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = {1, 0, leaves};
  const MotionBox mine = boxes[leaves + a];
  while (depth > 0) {
    const Node node = stack[--depth];
    if (node.begin + node.size <= first || node.begin >= count || !may_meet(mine, boxes[node.index]))
      continue;
    if (node.size == 1) {
      visit(node.begin);
      continue;
    }
    const std::size_t half = node.size / 2;
    stack[depth++] = {2 * node.index + 1, node.begin + half, half};
    stack[depth++] = {2 * node.index, node.begin, half};
  }
}

bool is_caught(const Crossing& crossing, std::size_t batch) {
  const auto at = std::lower_bound(crossing.caught.begin(), crossing.caught.end(), int(batch * kLane));
  return at != crossing.caught.end() && std::size_t(*at) < (batch + 1) * kLane;
}

}  // namespace

void place_boxes(const Exec& exec, const Model& model, State& state) {
  std::vector<MotionBox>& boxes = state.crossing.boxes;
  const std::size_t count = batches_of(model), leaves = std::bit_ceil(count);
  boxes.resize(2 * leaves);
  parallel_for(
      exec, leaves,
      [&](std::size_t batch) {
        boxes[leaves + batch] = box_of_batch(model, state.system, std::min(batch, count - 1));
      },
      64);
  for (std::size_t level = leaves / 2; level > 0; level /= 2)
    parallel_for(
        exec, level,
        [&](std::size_t n) { boxes[level + n] = around(boxes[2 * (level + n)], boxes[2 * (level + n) + 1]); },
        256);
}

bool find_meetings(const Exec& exec, const Model& model, State& state, bool all) {
  Crossing& crossing = state.crossing;
  const std::size_t count = batches_of(model), leaves = crossing.boxes.size() / 2;
  crossing.found.resize((count + kBatches - 1) / kBatches);
  parallel_for(exec, crossing.found.size(), [&](std::size_t piece) {
    crossing.found[piece].clear();
    FindMeetings find{model, state, state.system, model.params.collision.thickness, crossing.found[piece]};
    for (std::size_t a = piece * kBatches; a < std::min((piece + 1) * kBatches, count); a++) {
      if (!all && !is_caught(crossing, a)) continue;
      visit_boxes(crossing.boxes, a, all ? a : 0, count, [&](std::size_t b) {
        if (!all && b < a && is_caught(crossing, b)) return;  // b looks at a
        visit_pairs(model, state.system, a, b, crossing.boxes[leaves + b], [&](int i, int j) { find(i, j); });
      });
    }
  });
  const std::size_t before = crossing.meetings.size();
  for (const auto& found : crossing.found)
    crossing.meetings.insert(crossing.meetings.end(), found.begin(), found.end());
  return crossing.meetings.size() > before;
}

}  // namespace turgor::cloth
