#include "turgor/models/lattice/surface/surface.hpp"

#include <array>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr double kPi = 3.141592653589793;

struct Measured {
  double area = 0, volume = 0;  // [m²], [m³]
};
Measured measure(const TriMesh& mesh, int begin, int end) {
  Measured m;
  for (int n = begin; n < end; n++) {
    const auto [a, b, c] = mesh.triangles[std::size_t(n)];
    const Vec3d x(mesh.vertices[std::size_t(a)]), y(mesh.vertices[std::size_t(b)]),
        z(mesh.vertices[std::size_t(c)]);
    m.area += 0.5 * norm(cross(y - x, z - x));
    m.volume += dot(x, cross(y, z)) / 6;
  }
  return m;
}
Measured measure(const TriMesh& mesh) { return measure(mesh, 0, int(mesh.triangles.size())); }

/// Number of edges that are not matched by exactly one reverse edge, if vertices with the same `name` are
/// merged.
template <class Name>
long open_edges(const BodySurface& surface, const Name& name) {
  using Key = decltype(name(0));
  std::map<std::pair<Key, Key>, int> balance;
  for (const Int3 t : surface.triangles)
    for (int n = 0; n < 3; n++) {
      const Key a = name(t[n]), b = name(t[(n + 1) % 3]);
      if (a == b) continue;
      balance[{a, b}]++;
      balance[{b, a}]--;
    }
  long open = 0;
  for (const auto& [edge, count] : balance) open += count != 0;
  return open;
}

/// Rest position and node of a vertex: equal for the coincident vertices of skin, caps and walls.
auto embedding_key(const BodySurface& surface) {
  return [&surface](int v) {
    const Vec3 x = surface.rest[std::size_t(v)];
    return std::array<double, 4>{x.x, x.y, x.z, double(surface.slot[std::size_t(v)])};
  };
}

// The surface of a ball has its area and volume within 2 %.
TEST(LatticeSurface, BallAreaAndVolume) {
  const double radius = 30;
  const Model model = body_of(soft_ball(96, radius), {4, 4, 4});
  const State state = make_state(model);
  const BodySurface surface = build_surface(model, state.cuts);
  const Measured m = measure(deformed_surface(model, state, surface, Shown::kNothing));
  const double r = radius * kVoxel;
  EXPECT_NEAR(m.area / (4 * kPi * r * r), 1, 0.02);
  EXPECT_NEAR(m.volume / (4.0 / 3 * kPi * r * r * r), 1, 0.02);
  EXPECT_EQ(surface.skin_triangles, int(surface.triangles.size()));
}

// Any number of threads finds the same points in the same order.
TEST(LatticeSurface, EqualOnAnyThreads) {
  const CtVolume ct = soft_ball(64, 20);
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  const BodySurface one = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(1));
  for (const int threads : {2, 3, 8}) {
    const BodySurface many = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(threads));
    EXPECT_EQ(many.triangles, one.triangles);
    EXPECT_EQ(many.rest, one.rest);
    EXPECT_EQ(many.slot, one.slot);
  }
  EXPECT_GT(one.triangles.size(), 1000u);
}

// The surface of a ball is watertight and has Euler characteristic 2.
TEST(LatticeSurface, BallIsWatertight) {
  const Model model = body_of(soft_ball(64, 20), {4, 4, 4});
  const BodySurface surface = build_surface(model, make_state(model).cuts);
  std::map<std::pair<int, int>, int> edges;
  for (const Int3 t : surface.triangles)
    for (int n = 0; n < 3; n++) edges[{t[n], t[(n + 1) % 3]}]++;
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(edges.contains({edge.second, edge.first}));
  }
  EXPECT_EQ(long(surface.rest.size()) - long(edges.size()) / 2 + long(surface.triangles.size()), 2)
      << "Euler";
}

// Normals point outward for any axes of the CT.
TEST(LatticeSurface, NormalsPointOutward) {
  CtVolume ct = soft_ball(48, 15);
  for (const Mat3d& axes :
       {Mat3d{}, Mat3d{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}, Mat3d{{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}}) {
    ct.grid.axes = axes;
    const Model model = body_of(ct, {4, 4, 4});
    const State state = make_state(model);
    const TriMesh mesh = deformed_surface(model, state, build_surface(model, state.cuts), Shown::kNothing);
    const Vec3d middle = point_at(ct.grid, {23.5, 23.5, 23.5});
    for (std::size_t v = 0; v < mesh.vertices.size(); v++)
      ASSERT_GT(dot(Vec3d(mesh.normals[v]), normalized(Vec3d(mesh.vertices[v]) - middle)), 0.9);
    EXPECT_GT(measure(mesh).volume, 0);
  }
}

// The surface is capped where the scan ends.
TEST(LatticeSurface, CappedAtEndOfScan) {
  const Model model = body_of(slab_ct(), {4, 4, 4});
  const State state = make_state(model);
  const BodySurface surface = build_surface(model, state.cuts);
  EXPECT_EQ(open_edges(surface, embedding_key(surface)), 0);
  const Measured m = measure(deformed_surface(model, state, surface, Shown::kNothing));
  EXPECT_NEAR(m.volume / (64 * 64 * 22 * 1e-9), 1, 0.02);
  EXPECT_NEAR(m.area / ((2 * 64 * 64 + 4 * 64 * 22) * 1e-6), 1, 0.02);
}

// The triangles in the planes where the scan ends are caps, and no others. They have no stretch of skin,
// however the body is stretched.
TEST(LatticeSurface, CapsLieWhereScanEnds) {
  const Model model = body_of(slab_ct(), {4, 4, 4});
  State state = make_state(model);
  const BodySurface surface = build_surface(model, state.cuts);
  const Vec3 last = hadamard(Vec3(model.anatomy.lattice.size - Int3{1, 1, 1}), model.anatomy.lattice.spacing);
  const auto is_at_end = [&](Int3 t) {
    const Vec3 a = surface.rest[std::size_t(t.x)], b = surface.rest[std::size_t(t.y)],
               c = surface.rest[std::size_t(t.z)];
    for (int axis = 0; axis < 3; axis++)
      for (const float end : {0.0f, last[axis]})
        if (std::max({std::abs(a[axis] - end), std::abs(b[axis] - end), std::abs(c[axis] - end)}) < 1e-6f)
          return true;
    return false;
  };
  EXPECT_GT(surface.cap_triangles, 100);
  const int skin = surface.skin_triangles - surface.cap_triangles;
  EXPECT_GT(skin, 100);
  for (int n = 0; n < surface.skin_triangles; n++)
    ASSERT_EQ(is_at_end(surface.triangles[std::size_t(n)]), n >= skin) << n;

  for (std::size_t s = 0; s < state.motion.u.x.size(); s++) {
    const Vec3 rest = rest_position(model.anatomy.lattice, slot_node(model.anatomy.lattice, int(s)));
    state.motion.u.set(s, rest * 0.1f);
  }
  const TriMesh stretched = deformed_surface(model, state, surface, Shown::kStretch);
  for (int n = 0; n < surface.skin_triangles; n++)
    for (const int v : {surface.triangles[std::size_t(n)].x, surface.triangles[std::size_t(n)].y})
      ASSERT_NEAR(stretched.scalars[std::size_t(v)], n < skin ? 0.21 : 0, 1e-3) << n;
}

// A closed cut keeps the skin's area, the volume and the normals.
TEST(LatticeSurface, ClosedCutKeepsSkinAndVolume) {
  const Model model = body_of(slab_ct(), {4, 4, 4});
  State state = make_state(model);
  const BodySurface whole = build_surface(model, state.cuts);
  const TriMesh before = deformed_surface(model, state, whole, Shown::kNothing);
  cut_across_y(model, state, 0.0323, [](Vec3d p) { return p.z > 0.012 && std::abs(p.x - 0.032) < 0.013; });
  const BodySurface cut = build_surface(model, state.cuts);
  const TriMesh after = deformed_surface(model, state, cut, Shown::kNothing);

  EXPECT_EQ(open_edges(cut, embedding_key(cut)), 0) << "closed through the walls";
  const Measured skin = measure(before), skin_after = measure(after, 0, cut.skin_triangles);
  EXPECT_NEAR(skin_after.area / skin.area, 1, 1e-5);
  EXPECT_NEAR(measure(after).volume / skin.volume, 1, 1e-5);
  const Measured walls = measure(after, cut.skin_triangles, int(cut.triangles.size()));
  EXPECT_NEAR(walls.volume / skin.volume, 0, 1e-5) << "the two walls coincide";
  // The edge of the cut lies on the old skin and has its normals.
  long lips = 0;
  for (std::size_t v = 0; v < cut.rest.size(); v++) {
    if (cut.twin[v] < 0) continue;
    lips++;
    const auto twin = std::size_t(cut.twin[v]);
    ASSERT_EQ(cut.rest[v], cut.rest[twin]);
    ASSERT_NE(cut.slot[v], cut.slot[twin]);
    ASSERT_GT(dot(after.normals[v], after.normals[twin]), 0.9999f);
  }
  EXPECT_GT(lips, 20);
}

// An open cut has two lips and walls between them.
TEST(LatticeSurface, OpenCutHasLipsAndWalls) {
  const Model model = body_of(slab_ct(), {4, 4, 4});
  const double at = 0.0323, bottom = 0.0102, gape = 0.005;
  State state = make_state(model);
  cut_across_y(model, state, at, [&](Vec3d p) { return p.z > bottom; });  // from end to end of the scan
  move(model, state, [&](Vec3d p) { return Vec3d{0, p.y >= at ? gape : 0, 0}; });
  const BodySurface surface = build_surface(model, state.cuts);
  const TriMesh mesh = deformed_surface(model, state, surface, Shown::kDisplacement);
  EXPECT_EQ(open_edges(surface, embedding_key(surface)), 0);

  long lips = 0;
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const int twin = surface.twin[v];
    if (twin < 0 || surface.rest[v].z < 0.02) continue;
    lips++;
    EXPECT_NEAR(norm(mesh.vertices[v] - mesh.vertices[std::size_t(twin)]), gape, 2e-5);
  }
  EXPECT_GT(lips, 20);
  // Each wall is about as deep as the cut: its lower edge is at most a cell deeper.
  const double depth = 0.022 - bottom, length = 0.064;
  double side[2] = {0, 0};
  for (int n = surface.skin_triangles; n < int(surface.triangles.size()); n++) {
    const auto [a, b, c] = mesh.triangles[std::size_t(n)];
    const auto scalar = [&](int v) { return mesh.scalars[std::size_t(v)]; };
    const float most = std::max({scalar(a), scalar(b), scalar(c)}),
                least = std::min({scalar(a), scalar(b), scalar(c)});
    if (most - least < 1e-3f) side[most > 1e-3f] += measure(mesh, n, n + 1).area;
  }
  for (const double area : side) EXPECT_NEAR(area / (depth * length), 1, 0.25);
}

// The lips of a cut that ends in tissue meet at its ends, open without a kink, and keep nine tenths of their
// gape two cells away from the ends. They gape by less or more than a cell.
void expect_lips_meet_at_ends(double gape) {
  const Model model = body_of(slab_ct(), {4, 4, 4});
  const double at = 0.0323, step = 0.004;
  State state = make_state(model);
  cut_across_y(model, state, at, [](Vec3d p) { return p.z > 0.012 && std::abs(p.x - 0.032) < 0.013; });
  move(model, state, [&](Vec3d p) { return Vec3d{0, p.y >= at ? gape : 0, 0}; });
  BodySurface surface = build_surface(model, state.cuts);
  double first = 1, last = 0;
  for (Lip& lip : surface.lips) {
    lip.along = surface.rest[std::size_t(lip.left)].x;
    first = std::min(first, double(lip.along)), last = std::max(last, double(lip.along));
  }
  surface.plan = nullptr;  // it has the ends of lips without arc lengths
  const TriMesh mesh = deformed_surface(model, state, surface, Shown::kNothing);
  EXPECT_EQ(open_edges(surface, embedding_key(surface)), 0);
  long ends = 0, inner = 0;
  for (const Lip& lip : surface.lips) {
    const double gap = norm(mesh.vertices[std::size_t(lip.left)] - mesh.vertices[std::size_t(lip.right)]);
    const double inside = std::min(double(lip.along) - first, last - double(lip.along));
    if (inside < 0.02 * step) {
      ends++;
      EXPECT_LT(gap, 0.05 * gape);
    }
    const double t = std::min(1.0, inside / (2.5 * step));
    EXPECT_LT(gap, gape * (t * (2 - t) + 0.05));
    EXPECT_GT(gap, gape * (0.8 * t * (2 - t) - 0.05)) << "cells at the end open less";
    if (inside > 2.05 * step) {
      inner++;
      EXPECT_NEAR(gap, gape, 0.1 * gape);
    }
  }
  EXPECT_GE(ends, 2);
  EXPECT_GT(inner, 5);
}
TEST(LatticeSurface, LipsMeetAtEndsOfCut) {
  for (const double gape : {0.002, 0.006, 0.011}) expect_lips_meet_at_ends(gape);
}

// Two separated halves have closed surfaces.
TEST(LatticeSurface, SeparatedHalvesAreClosed) {
  const double radius = 30;
  const Model model = body_of(soft_ball(96, radius), {4, 4, 4});
  for (const double at : {0.0491, 0.048, 0.0509}) {
    State state = make_state(model);
    cut_across_y(model, state, at, [](Vec3d) { return true; });
    move(model, state, [&](Vec3d p) { return Vec3d{0, p.y >= at ? 0.01 : -0.01, 0}; });
    const BodySurface surface = build_surface(model, state.cuts);
    EXPECT_EQ(open_edges(surface, [&](int v) { return embedding_key(surface)(v); }), 0);
    const TriMesh mesh = deformed_surface(model, state, surface, Shown::kNothing);
    const double r = radius * kVoxel, c = at - 0.048;
    EXPECT_NEAR(measure(mesh).volume / (4.0 / 3 * kPi * r * r * r), 1, 0.02);
    const double walls = measure(mesh, surface.skin_triangles, int(surface.triangles.size())).area;
    EXPECT_NEAR(walls / (2 * kPi * (r * r - c * c)), 1, 0.03);
  }
}

// The scalars for stretch and displacement are those of a uniform stretch.
TEST(LatticeSurface, ScalarsOfUniformStretch) {
  const Model model = body_of(soft_ball(64, 20), {4, 4, 4});
  State state = make_state(model);
  move(model, state, [](Vec3d p) { return (p - Vec3d{0.032, 0.032, 0.032}) * 0.1; });
  const BodySurface surface = build_surface(model, state.cuts);
  for (const float s : deformed_surface(model, state, surface, Shown::kStretch).scalars)
    ASSERT_NEAR(s, 0.21, 0.01);
  const TriMesh mesh = deformed_surface(model, state, surface, Shown::kDisplacement);
  for (const float d : mesh.scalars) ASSERT_NEAR(d, 0.1 * 0.02, 1e-4);
}

// No vertex follows air or removed nodes.
TEST(LatticeSurface, NoVertexFollowsAirOrRemovedNodes) {
  const Model model = body_of(slab_ct(), {4, 4, 4});
  State state = make_state(model);
  for (int k = 4; k < model.anatomy.lattice.size.z; k++)
    for (int i = 5; i < 12; i++) {
      const auto slot = std::size_t(node_slot(model.anatomy.lattice, i, 8, k));
      if (is_body(model.anatomy.tissue[slot])) state.cuts.removed[slot] = 1, state.cuts.removed_nodes++;
    }
  const BodySurface surface = build_surface(model, state.cuts);
  EXPECT_EQ(open_edges(surface, embedding_key(surface)), 0);
  EXPECT_LT(surface.skin_triangles, int(surface.triangles.size())) << "the exposed faces are walls";
  for (const int slot : surface.slot) {
    ASSERT_TRUE(is_body(model.anatomy.tissue[std::size_t(slot)]));
    ASSERT_FALSE(state.cuts.removed[std::size_t(slot)]);
  }
}

// Any pattern of cuts leaves the surface closed.
TEST(LatticeSurface, AnyCutPatternStaysClosed) {
  const Model model = body_of(soft_ball(20, 6.5), {4, 4, 4});
  const FineLattice fine = fine_lattice(model);
  std::uint32_t random = 12345;
  for (int trial = 0; trial < 20; trial++) {
    State state = make_state(model);
    for (int k = 0; k < fine.size.z; k++)
      for (int j = 0; j < fine.size.y; j++)
        for (int i = 0; i < fine.size.x; i++)
          for (int f = 0; f < kFamilyCount; f++) {
            random = random * 1664525 + 1013904223;
            if (int(random >> 24) > 20 + 10 * trial) continue;
            if (!contains(fine, Int3{i, j, k} + kFamilies[std::size_t(f)])) continue;
            CutEdge edge = cut_edge_at(fine, {i, j, k}, f);
            edge.fraction = Real(0.1 + 0.8 * double(random >> 8 & 255) / 255);
            state.cuts.edges.push_back(edge);
          }
    const BodySurface surface = build_surface(model, state.cuts);
    // If three cuts meet in a face, both neighbors omit its center; all other edges are matched.
    ASSERT_EQ(open_edges(surface, embedding_key(surface)), 0) << "trial " << trial;
  }
}

// Rest points of the walls are positions of the cut in the CT.
TEST(LatticeSurface, RestPointsLieInCt) {
  const CtVolume ct = slab_ct();
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  cut_across_y(model, state, 0.0323, [](Vec3d p) { return p.z > 0.01; });
  move(model, state, [](Vec3d) { return Vec3d{0.1, 0.1, 0.1}; });
  const BodySurface surface = build_surface(model, state.cuts);
  const std::vector<Vec3d> points = rest_points(model, surface);
  for (int n = surface.skin_triangles; n < int(surface.triangles.size()); n++) {
    const Vec3d index = index_at(ct.grid, points[std::size_t(surface.triangles[std::size_t(n)].x)]);
    ASSERT_NEAR(index.y, 0.0323 / kVoxel - 0.5, 1e-3);
    ASSERT_LE(index.z, 22.5);
  }
}

}  // namespace
}  // namespace turgor::lattice
