// Whether anything of a sheet would meet on its way through a step (ccd.hpp), as loops over plain
// pointers: boxes around vertices and their ways, pairs of vertices that come near each other, and what these
// pairs would do.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/ccd/ccd_flatness.hpp"
#include "turgor/models/cloth/forces/wind_kernels.hpp"

namespace turgor::cloth {

constexpr int kGuardLeaf = 32;    // vertices in the smallest boxes
constexpr int kGuardLevels = 32;  // more than a tree of halves over all ints has

struct VertexPair {
  int i, j;
};
struct CcdResult {
  int pairs = 0;  // more than there is room for: not all are listed
  std::uint32_t meets = 0;
};

/// The motion is in `force`, what is measured of it in `inverse` (measure_triangles).
struct CcdView {
  SheetView sheet;
  const Int3* triangles;
  TrianglesAround around;
  MotionBox* boxes;
  int level_begin[kGuardLevels];
  int levels, count;  // of the tree; vertices
  double thickness;
  VertexPair* pairs;  // room for as many as there are vertices
  CcdResult* answer;

  TURGOR_HD MovingTriangle<Real> moving(int t) const {
    const auto [a, b, c] = triangles[t];
    const auto i = std::size_t(a), j = std::size_t(b), k = std::size_t(c);
    const VectorsView x = sheet.before, d = sheet.force;
    return moving_triangle<Real>(x[j] - x[i], x[k] - x[i], d[j] - d[i], d[k] - d[i]);
  }
  TURGOR_HD MotionBox box_of(int v) const {
    const Vec3 x = sheet.before[std::size_t(v)], d = sheet.force[std::size_t(v)];
    return {x, x, d, d, reach_of(sheet.inverse[0].x[v])};
  }
};

struct SetMotion {
  SheetView sheet;

  TURGOR_HD void operator()(std::size_t v) const { sheet.force.set(v, sheet.x[v] - sheet.before[v]); }
};
struct MeasureUp {
  CcdView g;

  TURGOR_HD void operator()(std::size_t v) const {
    Vec3 up;
    Real longest2 = 0;
    for (int n = g.around.begin[v]; n < g.around.begin[v + 1]; n++) {
      const MovingTriangle<Real> t = g.moving(g.around.item[n]);
      up += t.normal[0];
      longest2 = larger(longest2, t.longest2);
    }
    g.sheet.inverse[1].set(v, up);
    g.sheet.inverse[0].x[v] = longest2;
  }
};
struct MeasureFlatness {
  CcdView g;

  TURGOR_HD void operator()(std::size_t v) const {
    const Vec3 up = g.sheet.inverse[1][v];
    Real flatness = 2;
    for (int n = g.around.begin[v]; n < g.around.begin[v + 1]; n++) {
      const MovingTriangle<Real> t = g.moving(g.around.item[n]);
      bool narrow = true, wide = true;
      for (const Vec3& normal : t.normal) {
        narrow = narrow && outside_of(normal, up, kNarrow) < 0;
        wide = wide && outside_of(normal, up, kWide) < 0;
      }
      if (!narrow) flatness = smaller(flatness, wide ? 1 : 0);
    }
    g.sheet.inverse[0].y[v] = flatness;
  }
};
struct PlaceLeaf {
  CcdView g;

  TURGOR_HD void operator()(std::size_t leaf) const {
    const int begin = int(leaf) * kGuardLeaf;
    MotionBox box = g.box_of(begin);
    for (int v = begin + 1; v < g.count && v < begin + kGuardLeaf; v++) box = cloth::around(box, g.box_of(v));
    g.boxes[leaf] = box;
  }
};
struct PlaceLevel {
  CcdView g;
  int level;  // from 1 on

  TURGOR_HD void operator()(std::size_t n) const {
    const MotionBox *below = g.boxes + g.level_begin[level - 1] + 2 * n,
                    *end = g.boxes + g.level_begin[level];
    g.boxes[g.level_begin[level] + int(n)] = below + 1 < end ? cloth::around(below[0], below[1]) : below[0];
  }
};

/// What is asked of two vertices and the triangles around them.
struct PairLook {
  const CcdView& g;

  TURGOR_HD bool flat(int v, Real least) const { return g.sheet.inverse[0].y[v] >= least; }
  TURGOR_HD bool has(Int3 t, int v) const { return t.x == v || t.y == v || t.z == v; }
  template <class Visit>
  TURGOR_HD void for_triangles(int v, const Visit& visit) const {
    for (int n = g.around.begin[v]; n < g.around.begin[v + 1]; n++) visit(g.triangles[g.around.item[n]]);
  }
  TURGOR_HD bool are_adjacent(int i, int j) const {
    bool found = false;
    for_triangles(i, [&](Int3 t) { found = found || has(t, j); });
    return found;
  }
  /// As FindMeetings::unfold.
  TURGOR_HD bool unfold(int i, int j) const {
    if (are_adjacent(i, j)) return flat(i, 1) && flat(j, 1);
    if (!flat(i, 2) || !flat(j, 2)) return false;
    bool found = false;
    for_triangles(i, [&](Int3 t) {
      for (int k = 0; k < 3; k++) found = found || (t[k] != i && flat(t[k], 2) && are_adjacent(j, t[k]));
    });
    return found;
  }
  TURGOR_HD double extent(const Ways& ways, int v, Vec3d n, Vec3d origin, Vec3d drift) const {
    double most = -INFINITY;
    for_triangles(v, [&](Int3 t) {
      for (int k = 0; k < 3; k++) {
        const double at = dot(n, ways.place(t[k]) - origin);
        most = std::max(most, std::max(at, at + dot(n, ways.way(t[k]) - drift)));
      }
    });
    return most;
  }
  /// As FindMeetings::are_parted.
  TURGOR_HD bool are_parted(const Ways& ways, int i, int j) const {
    const Vec3d origin = ways.place(i), drift = ways.way(i);
    for (const int star : {i, j}) {
      Vec3d n;
      for_triangles(star, [&](Int3 t) {
        n += cross(ways.place(t.y) - ways.place(t.x), ways.place(t.z) - ways.place(t.x));
      });
      const double length = norm(n);
      if (!(length > 0)) continue;
      n *= (dot(n, ways.place(j) - origin) < 0 ? -1 : 1) / length;
      if (extent(ways, i, n, origin, drift) + extent(ways, j, -n, origin, drift) < -kClosest * g.thickness)
        return true;
    }
    return false;
  }
  TURGOR_HD bool meet(const Ways& ways, const std::array<int, 4>& v, bool are_edges) const {
    const Ways::Four four = ways.four(v, are_edges);
    return ways.may_meet(four) && ways.meet(four, v);
  }
  /// Vertex and triangles, and edges, of the two.
  TURGOR_HD bool any_meets(const Ways& ways, int i, int j) const {
    bool found = false;
    for_triangles(j, [&](Int3 t) {
      if (!found && !has(t, i)) found = meet(ways, {i, t.x, t.y, t.z}, false);
    });
    for_triangles(i, [&](Int3 t) {
      if (!found && !has(t, j)) found = meet(ways, {j, t.x, t.y, t.z}, false);
    });
    for_triangles(i, [&](Int3 s) {
      for_triangles(j, [&](Int3 t) {
        for (int a = 0; a < 3; a++)
          for (int b = 0; b < 3; b++) {
            const int p = s[a], q = t[b];
            if (!found && p != i && q != j && p != j && q != i && p != q)
              found = meet(ways, {i, p, j, q}, true);
          }
      });
    });
    return found;
  }
  TURGOR_HD bool meet(int i, int j) const {
    const Ways ways{g.sheet.before, g.sheet.force, g.sheet.x_rest, g.thickness};
    return !are_parted(ways, i, j) && any_meets(ways, i, j);
  }
  TURGOR_HD bool come_near(int i, int j) const {
    const auto v = std::size_t(i), w = std::size_t(j);
    const Vec3 e = g.sheet.before[w] - g.sheet.before[v], f = g.sheet.force[w] - g.sheet.force[v];
    const Real when = smaller(larger(-dot(e, f) / larger(dot(f, f), 1e-30f), 0), 1);
    const Vec3 nearest = e + f * when;
    const Real longest2 = larger(g.sheet.inverse[0].x[w], g.sheet.inverse[0].x[v]);
    return dot(nearest, nearest) < longest2 * 0.50001f;
  }
};

/// Calls take(j) for all later vertices that vertex i comes near and is not beside in flat cloth, until it
/// says that it is enough.
template <class Take>
TURGOR_HD inline void visit_near(const CcdView& g, int i, const Take& take) {
  const MotionBox mine = g.box_of(i);
  const PairLook pair{g};
  struct Node {
    int level, index;
  };
  Node stack[2 * kGuardLevels];
  int depth = 0;
  stack[depth++] = {g.levels - 1, 0};
  while (depth > 0) {
    const auto [level, index] = stack[--depth];
    if (((long long)(index) + 1) * kGuardLeaf << level <= i) continue;  // all before it
    if (!may_meet(mine, g.boxes[g.level_begin[level] + index])) continue;
    if (level > 0) {
      const int below = g.level_begin[level] - g.level_begin[level - 1];
      if (2 * index + 1 < below) stack[depth++] = {level - 1, 2 * index + 1};
      stack[depth++] = {level - 1, 2 * index};
      continue;
    }
    for (int j = std::max(i + 1, index * kGuardLeaf); j < g.count && j < (index + 1) * kGuardLeaf; j++)
      if (pair.come_near(i, j) && !pair.unfold(i, j) && take(j)) return;
  }
}

/// Lists the pairs of a vertex: few have any, and what is asked of these takes so long that a thread each
/// does it.
struct ListPairs {
  CcdView g;

  TURGOR_HD void operator()(std::size_t vertex) const {
    visit_near(g, int(vertex), [&](int j) {
      const int n = atomic_next(g.answer->pairs);
      if (n < g.count) g.pairs[n] = {int(vertex), j};
      return n >= g.count;
    });
  }
};
struct LookAtPair {
  CcdView g;

  TURGOR_HD void operator()(std::size_t n) const {
    if (int(n) >= g.answer->pairs || shared_load(g.answer->meets) != 0) return;
    const VertexPair pair = g.pairs[n];
    if (PairLook{g}.meet(pair.i, pair.j)) atomic_max(g.answer->meets, 1);
  }
};
/// Where the list was too short for all pairs: a vertex with each of its own.
struct LookAtUnlisted {
  CcdView g;

  TURGOR_HD void operator()(std::size_t vertex) const {
    if (g.answer->pairs <= g.count) return;
    visit_near(g, int(vertex), [&](int j) {
      if (PairLook{g}.meet(int(vertex), j)) atomic_max(g.answer->meets, 1);
      return shared_load(g.answer->meets) != 0;
    });
  }
};

}  // namespace turgor::cloth
