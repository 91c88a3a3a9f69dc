// Kernels of CCD for the device (ccd.hpp): motion boxes, pairs of vertices that come near each other, and
// collision tests of their triangles and edges. They tell whether anything collides; impact zones are made on
// the host.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/ccd/ccd_flatness.hpp"
#include "turgor/models/cloth/forces/wind_kernels.hpp"

namespace turgor::cloth {

constexpr int kCcdLeaf = 32;    // vertices in the smallest boxes
constexpr int kCcdLevels = 32;  // exceeds the depth of a binary tree over all ints

struct VertexPair {
  int i, j;
};
struct CcdResult {
  int pairs = 0;  // may exceed the capacity; then the list is incomplete
  std::uint32_t collides = 0;
};

/// Motion, mesh, box tree and results.
struct CcdView {
  CcdMotion motion;
  ConstVectorsView x_rest;
  const Int3* triangles;
  TrianglesAround around;
  MotionBox* boxes;
  int level_begin[kCcdLevels];
  int levels, count;  // levels of the tree; vertices
  double thickness;
  VertexPair* pairs;  // capacity: `count`
  CcdResult* answer;

  TURGOR_HD MovingTriangle<Real> moving(int t) const {
    const auto [a, b, c] = triangles[t];
    const auto i = std::size_t(a), j = std::size_t(b), k = std::size_t(c);
    const VectorsView x = motion.start, d = motion.displacement;
    return moving_triangle<Real>(x[j] - x[i], x[k] - x[i], d[j] - d[i], d[k] - d[i]);
  }
  TURGOR_HD MotionBox box_of(int v) const {
    const Vec3 x = motion.start[std::size_t(v)], d = motion.displacement[std::size_t(v)];
    return {x, x, d, d, reach_of(motion.longest2[v])};
  }
};

struct SetDisplacement {
  ConstVectorsView x;
  CcdMotion motion;

  TURGOR_HD void operator()(std::size_t v) const { motion.displacement.set(v, x[v] - motion.start[v]); }
};
/// Sums normals and finds the longest edge around a vertex.
struct MeasureNormals {
  CcdView g;

  TURGOR_HD void operator()(std::size_t v) const {
    Vec3 axis;
    Real longest2 = 0;
    for (int n = g.around.begin[v]; n < g.around.begin[v + 1]; n++) {
      const MovingTriangle<Real> t = g.moving(g.around.item[n]);
      axis += t.normal[0];
      longest2 = larger(longest2, t.longest2);
    }
    g.motion.normal.set(v, axis);
    g.motion.longest2[v] = longest2;
  }
};
/// Flatness around a vertex, from the cones of its triangles' normals.
struct MeasureFlatness {
  CcdView g;

  TURGOR_HD void operator()(std::size_t v) const {
    const Vec3 axis = g.motion.normal[v];
    Real flatness = 2;
    for (int n = g.around.begin[v]; n < g.around.begin[v + 1]; n++) {
      const MovingTriangle<Real> t = g.moving(g.around.item[n]);
      bool narrow = true, wide = true;
      for (const Vec3& normal : t.normal) {
        narrow = narrow && outside_of(normal, axis, kNarrow) < 0;
        wide = wide && outside_of(normal, axis, kWide) < 0;
      }
      if (!narrow) flatness = smaller(flatness, wide ? 1 : 0);
    }
    g.motion.flatness[v] = flatness;
  }
};
/// Box of the vertices of a leaf.
struct BuildLeaf {
  CcdView g;

  TURGOR_HD void operator()(std::size_t leaf) const {
    const int begin = int(leaf) * kCcdLeaf;
    MotionBox box = g.box_of(begin);
    for (int v = begin + 1; v < g.count && v < begin + kCcdLeaf; v++) box = cloth::around(box, g.box_of(v));
    g.boxes[leaf] = box;
  }
};
/// Box of two boxes of the level below.
struct BuildLevel {
  CcdView g;
  int level;  // at least 1

  TURGOR_HD void operator()(std::size_t n) const {
    const MotionBox *below = g.boxes + g.level_begin[level - 1] + 2 * n,
                    *end = g.boxes + g.level_begin[level];
    g.boxes[g.level_begin[level] + int(n)] = below + 1 < end ? cloth::around(below[0], below[1]) : below[0];
  }
};

/// Tests of two vertices and the triangles around them.
struct PairTest {
  const CcdView& g;

  TURGOR_HD bool flat(int v, Real least) const { return g.motion.flatness[v] >= least; }
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
  /// As FindCcdPairs::unfold.
  TURGOR_HD bool unfold(int i, int j) const {
    if (are_adjacent(i, j)) return flat(i, 1) && flat(j, 1);
    if (!flat(i, 2) || !flat(j, 2)) return false;
    bool found = false;
    for_triangles(i, [&](Int3 t) {
      for (int k = 0; k < 3; k++) found = found || (t[k] != i && flat(t[k], 2) && are_adjacent(j, t[k]));
    });
    return found;
  }
  TURGOR_HD double extent(const LinearMotion& linear, int v, Vec3d n, Vec3d origin, Vec3d motion) const {
    double most = -INFINITY;
    for_triangles(v, [&](Int3 t) {
      for (int k = 0; k < 3; k++) {
        const double at = dot(n, linear.position(t[k]) - origin);
        most = std::max(most, std::max(at, at + dot(n, linear.displacement(t[k]) - motion)));
      }
    });
    return most;
  }
  /// As FindCcdPairs::are_separated.
  TURGOR_HD bool are_separated(const LinearMotion& linear, int i, int j) const {
    const Vec3d origin = linear.position(i), motion = linear.displacement(i);
    for (const int star : {i, j}) {
      // normal of the star, toward the other vertex
      Vec3d n;
      for_triangles(star, [&](Int3 t) {
        n += cross(linear.position(t.y) - linear.position(t.x), linear.position(t.z) - linear.position(t.x));
      });
      const double length = norm(n);
      if (!(length > 0)) continue;
      n *= (dot(n, linear.position(j) - origin) < 0 ? -1 : 1) / length;
      // plane between the stars during the motion
      if (extent(linear, i, n, origin, motion) + extent(linear, j, -n, origin, motion) <
          -kClosest * g.thickness)
        return true;
    }
    return false;
  }
  TURGOR_HD bool collide(const LinearMotion& linear, const std::array<int, 4>& v, bool are_edges) const {
    const LinearMotion::PrimitivePair primitives = linear.primitives(v, are_edges);
    return linear.may_collide(primitives) && linear.collide(primitives, v);
  }
  /// Tests each vertex with the triangles around the other, and all pairs of edges.
  TURGOR_HD bool any_collides(const LinearMotion& linear, int i, int j) const {
    bool found = false;
    // vertices and triangles
    for_triangles(j, [&](Int3 t) {
      if (!found && !has(t, i)) found = collide(linear, {i, t.x, t.y, t.z}, false);
    });
    for_triangles(i, [&](Int3 t) {
      if (!found && !has(t, j)) found = collide(linear, {j, t.x, t.y, t.z}, false);
    });
    // edges
    for_triangles(i, [&](Int3 s) {
      for_triangles(j, [&](Int3 t) {
        for (int a = 0; a < 3; a++)
          for (int b = 0; b < 3; b++) {
            const int p = s[a], q = t[b];
            if (!found && p != i && q != j && p != j && q != i && p != q)
              found = collide(linear, {i, p, j, q}, true);
          }
      });
    });
    return found;
  }
  TURGOR_HD bool collide(int i, int j) const {
    const LinearMotion linear{g.motion.start, g.motion.displacement, g.x_rest, g.thickness};
    return !are_separated(linear, i, j) && any_collides(linear, i, j);
  }
  TURGOR_HD bool come_near(int i, int j) const {
    const auto v = std::size_t(i), w = std::size_t(j);
    const Vec3 e = g.motion.start[w] - g.motion.start[v],
               f = g.motion.displacement[w] - g.motion.displacement[v];
    const Real when = smaller(larger(-dot(e, f) / larger(dot(f, f), 1e-30f), 0), 1);
    const Vec3 nearest = e + f * when;
    const Real longest2 = larger(g.motion.longest2[w], g.motion.longest2[v]);
    return dot(nearest, nearest) < longest2 * 0.50001f;
  }
};

/// Calls take(j) for all later vertices that come near vertex i, except neighbors in flat cloth, until take
/// returns true.
template <class Take>
TURGOR_HD inline void visit_near(const CcdView& g, int i, const Take& take) {
  const MotionBox mine = g.box_of(i);
  const PairTest pair{g};
  struct Node {
    int level, index;
  };
  Node stack[2 * kCcdLevels];
  int depth = 0;
  // depth-first search of the box tree
  stack[depth++] = {g.levels - 1, 0};
  while (depth > 0) {
    const auto [level, index] = stack[--depth];
    if (((long long)(index) + 1) * kCcdLeaf << level <= i) continue;  // all vertices precede i
    if (!may_collide(mine, g.boxes[g.level_begin[level] + index])) continue;
    if (level > 0) {
      const int below = g.level_begin[level] - g.level_begin[level - 1];
      if (2 * index + 1 < below) stack[depth++] = {level - 1, 2 * index + 1};
      stack[depth++] = {level - 1, 2 * index};
      continue;
    }
    // vertices of a leaf
    for (int j = std::max(i + 1, index * kCcdLeaf); j < g.count && j < (index + 1) * kCcdLeaf; j++)
      if (pair.come_near(i, j) && !pair.unfold(i, j) && take(j)) return;
  }
}

/// Lists the pairs of a vertex. Few vertices have any, and their tests take long, so each pair gets a thread
/// of its own.
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
struct TestPair {
  CcdView g;

  TURGOR_HD void operator()(std::size_t n) const {
    if (int(n) >= g.answer->pairs || shared_load(g.answer->collides) != 0) return;
    const VertexPair pair = g.pairs[n];
    if (PairTest{g}.collide(pair.i, pair.j)) atomic_max(g.answer->collides, 1);
  }
};
/// Tests the pairs of a vertex if the list was too short.
struct TestUnlisted {
  CcdView g;

  TURGOR_HD void operator()(std::size_t vertex) const {
    if (g.answer->pairs <= g.count) return;
    visit_near(g, int(vertex), [&](int j) {
      if (PairTest{g}.collide(int(vertex), j)) atomic_max(g.answer->collides, 1);
      return shared_load(g.answer->collides) != 0;
    });
  }
};

}  // namespace turgor::cloth
