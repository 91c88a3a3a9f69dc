#include "turgor/models/cloth/contact/contact.hpp"

#include <algorithm>
#include <set>

#include "tests/models/cloth/sheets.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/cloth/contact/neighborhood.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"

namespace turgor::cloth {
namespace {

using Pairs = std::set<std::pair<int, int>>;

// The spatial hash finds exactly the pairs of a brute-force search, each once.
TEST(ClothContact, SpatialHashMatchesBruteForce) {
  const int count = 700;
  for (const double size : {0.02, 0.2, 3.0}) {
    Vectors points;
    points.resize(padded(count));
    Model all;
    all.count = count;
    shake(all, points, size, 5);
    const Real reach = 0.03f;
    SpatialHash near;
    sort_points(Exec(2), points, count, Real(2.05) * reach, near);
    Pairs found, expected;
    int visits = 0;
    for (int i = 0; i < count; i++) {
      visit_near(near, points[std::size_t(i)], reach, [&](int j, Vec3) { found.insert({i, j}), visits++; });
      for (int j = 0; j < count; j++) {
        const Vec3 d = points[std::size_t(j)] - points[std::size_t(i)];
        if (dot(d, d) < reach * reach) expected.insert({i, j});
      }
    }
    EXPECT_EQ(found, expected) << size;
    EXPECT_EQ(std::size_t(visits), found.size()) << "no pair is visited twice";
    if (size < 1) {
      EXPECT_GT(found.size(), std::size_t(count));
    }
  }
}

// Two shifted grids, as in the paper, miss more than half of the pairs.
TEST(ClothContact, ShiftedGridsMissPairs) {
  const double cell = 0.03;
  Vectors points;
  points.resize(padded(4000));
  Model all;
  all.count = 4000;
  shake(all, points, 0.15, 5);
  const auto same_cell = [cell](Vec3 a, Vec3 b, double shift) {
    for (int k = 0; k < 3; k++)
      if (std::floor((double(a[k]) + shift) / cell) != std::floor((double(b[k]) + shift) / cell))
        return false;
    return true;
  };
  int near = 0, found = 0;
  for (std::size_t i = 0; i < 4000; i++)
    for (std::size_t j = i + 1; j < 4000; j++) {
      if (norm(Vec3d(points[i]) - Vec3d(points[j])) >= cell) continue;
      near++;
      found += same_cell(points[i], points[j], 0) || same_cell(points[i], points[j], cell / 2);
    }
  EXPECT_NEAR(1 - double(found) / near, 0.55, 0.05);
}

/// Still air, so that folds come to rest.
Inputs on_a_table() {
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.obstacles.push_back(plane_obstacle({0, 0, 0}, {0, 0, 1}));
  return inputs;
}

// A cloth folded onto itself keeps its thickness.
TEST(ClothContact, FoldedClothKeepsThickness) {
  // The far half of a strip is laid over the near half with a small gap, then dropped.
  Params params{.fabric = {.warp = 200, .weft = 200, .shear = 40, .bend = 4}};
  params.collision.thickness = 0.0096;
  params.collision.iterations = 40;
  const Model model = must_build(flat_sheet(25), params);
  State state = make_state(model);
  for (std::size_t v = 0; v < 625; v++) {
    Vec3 x = state.x[v];
    const Real fold = 0.125f;
    if (x.x > fold) x = {2 * fold - x.x + 0.003f, x.y + 0.004f, 0.016f};
    state.x.set(v, x + Vec3{0, 0, 0.004f});
  }
  const Exec exec(2);
  for (int frame = 0; frame < 180; frame++) step(exec, model, state, on_a_table(), kFrame);
  const SelfDistance d = self_distance(exec, model, state);
  EXPECT_EQ(d.too_near, 0);
  EXPECT_GE(d.smallest, 0.99 * 0.0096);
  EXPECT_EQ(d.crossings, 0);
}

/// Height of the highest vertex, and the largest displacement over the frames.
struct RunSummary {
  double top = 0, moved = 0;
};
RunSummary run(const Model& model, State& state, const Inputs& inputs, int frames) {
  const Vectors before = state.x;
  const Exec exec(2);
  for (int frame = 0; frame < frames; frame++) step(exec, model, state, inputs, kFrame);
  RunSummary summary;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    summary.top = std::max(summary.top, double(state.x.z[v]));
    summary.moved = std::max(summary.moved, double(norm(state.x[v] - before[v])));
  }
  return summary;
}

Params stacked() {
  Params params{.fabric = {.law = Law::kSprings, .warp = 200, .weft = 200, .shear = 40, .bend = 1}};
  params.collision = {.thickness = 0.0096, .friction = 0.5, .iterations = 60};
  params.solver = {.method = Method::kChebyshev, .sweeps = 31};
  return params;
}

// Ten stacked sheets come to rest and keep the thickness.
TEST(ClothContact, TenSheetsRestApart) {
  TriMesh mesh;
  for (int layer = 0; layer < 10; layer++) {  // each in the hollows of the one below
    const double offset = layer % 2 * 0.005;
    const TriMesh sheet = make_sheet({.corner = {offset, offset, 0.0021 + 0.0068 * layer},
                                      .side = {0.09, 0, 0},
                                      .up = {0, 0.09, 0},
                                      .columns = 9,
                                      .rows = 9});
    for (const Int3 t : sheet.triangles)
      mesh.triangles.push_back({t.x + 100 * layer, t.y + 100 * layer, t.z + 100 * layer});
    mesh.vertices.insert(mesh.vertices.end(), sheet.vertices.begin(), sheet.vertices.end());
  }
  const Model model = must_build(mesh, stacked());
  State state = make_state(model);
  run(model, state, on_a_table(), 240);
  const RunSummary last = run(model, state, on_a_table(), 60);
  EXPECT_LT(last.moved, 0.001);
  EXPECT_NEAR(last.top, 0.061, 0.003);
  const SelfDistance d = self_distance(Exec(2), model, state);
  EXPECT_GE(d.smallest, 0.99 * 0.0096);
  EXPECT_EQ(d.crossings, 0);
}

// A strip in ten folds comes to rest and keeps the thickness.
TEST(ClothContact, TenFoldsRestApart) {
  const int layer_length = 24, length = 10 * layer_length, width = 21;
  const TriMesh strip = make_sheet({.side = {0.01 * (length - 1), 0, 0},
                                    .up = {0, 0.01 * (width - 1), 0},
                                    .columns = length - 1,
                                    .rows = width - 1});
  const Model model = must_build(strip, stacked());
  State state = make_state(model);
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {  // alternating directions
    const Vec3 x = state.x[v];
    const int column = int(std::lround(x.x / 0.01f)), layer = column / layer_length,
              along = column % layer_length;
    const int position_in_layer = layer % 2 == 0 ? along : layer_length - 1 - along;
    const double offset = layer % 2 == 0 ? 0 : 0.005;  // into the hollows of the layer below
    state.x.set(v, {Real(0.01 * position_in_layer + offset), x.y,
                    Real(0.002 + 0.0083 * layer)});  // the same bits with any compiler
  }
  run(model, state, on_a_table(), 400);
  const RunSummary last = run(model, state, on_a_table(), 60);
  const SelfDistance d = self_distance(Exec(2), model, state);
  EXPECT_LT(last.moved, 0.001);
  EXPECT_GT(last.top, 0.05);
  EXPECT_GE(d.smallest, 0.99 * 0.0096);
  EXPECT_EQ(d.crossings, 0);
}

// A fine sheet does not fall through a pinned sheet of large triangles. Two large triangles, pinned, and a
// small sheet that falls on their middle.
TEST(ClothContact, FineSheetRestsOnCoarseSheet) {
  TriMesh mesh = make_sheet(
      {.corner = {-0.2, -0.2, 0}, .side = {0.4, 0, 0}, .up = {0, 0.4, 0}, .columns = 2, .rows = 2});
  const TriMesh small = make_sheet(
      {.corner = {0.02, 0.05, 0.03}, .side = {0.08, 0, 0}, .up = {0, 0.08, 0}, .columns = 8, .rows = 8});
  for (const Int3 t : small.triangles) mesh.triangles.push_back({t.x + 9, t.y + 9, t.z + 9});
  mesh.vertices.insert(mesh.vertices.end(), small.vertices.begin(), small.vertices.end());
  Params params;
  params.collision.thickness = 0.006;
  const Model model = must_build(mesh, params);
  EXPECT_FALSE(model.large.triangles.empty());
  State state = make_state(model);
  for (int v = 0; v < 9; v++) ASSERT_TRUE(hold(model, state, v));
  Inputs inputs{.gravity = {0, 0, -9.81}};
  for (int frame = 0; frame < 120; frame++) step(Exec(1), model, state, inputs, kFrame);
  for (int v = 9; v < 90; v++)
    EXPECT_GT(state.x.z[std::size_t(model.model_vertex[std::size_t(v)])], 0.0055f) << v;
}

// The vectorized filter of neighbors misses no close pair of a double-precision reference.
TEST(ClothContact, VectorizedFilterMissesNoPair) {
  constexpr std::size_t kCount = 1600;
  constexpr Real kReach = 0.02f;
  RandomNumbers next{3};
  const auto random_vector = [&](double size) {
    const double x = next(), y = next(), z = next();
    return Vec3(Vec3d{x, y, z} * size);
  };
  Neighborhood near;
  for (Vectors* v : {&near.at, &near.rest, &near.edge, &near.rest_edge}) v->resize(padded(kCount));
  for (std::size_t n = 0; n < kCount; n++) {
    near.index.push_back(int(n));
    near.at.set(n, random_vector(0.04)), near.edge.set(n, random_vector(0.02));
    near.rest.set(n, random_vector(0.5)), near.rest_edge.set(n, random_vector(0.02));
  }
  const ContactDistances distances{kReach, 0.01f};
  const Vec3 a = random_vector(0.02), p = random_vector(0.02), q = random_vector(0.02), far{1, 1, 1};
  std::set<int> by_triangle, by_edge;
  visit_neighbors(near, NearTriangle{distances, -far, far, {a, p, q}, {{}, p, q}},
                  [&](int n) { by_triangle.insert(n); });
  visit_neighbors(near, NearEdge{distances, -far, far, {a, p}, {{}, p}}, [&](int n) { by_edge.insert(n); });
  int near_triangle = 0, near_edge = 0;
  for (std::size_t n = 0; n < kCount; n++) {
    const Vec3 x = near.at[n];
    const TrianglePoint on = nearest_on_triangle(Vec3d(x), Vec3d(a), Vec3d(a + p), Vec3d(a + q));
    const Vec3 rest = near.rest[n] - p * Real(on.weights.y) - q * Real(on.weights.z);
    const bool meets = on.distance < double(kReach) && on.distance < 0.9 * double(norm(rest));
    near_triangle += meets;
    EXPECT_TRUE(!meets || norm(rest) < 0.01f || by_triangle.count(int(n)) == 1) << n;
    const Vec3d edge(near.edge[n]), from = Vec3d(x) - edge * 0.5, along(p), offset = from - Vec3d(a);
    const double pp = dot(along, along), pq = dot(along, edge), qq = dot(edge, edge);
    const double s = (dot(offset, along) * qq - dot(offset, edge) * pq) / (pp * qq - pq * pq);
    const double t = (dot(offset, along) * pq - dot(offset, edge) * pp) / (pp * qq - pq * pq);
    const bool inside = s > 0 && s < 1 && t > 0 && t < 1;
    const bool meet = inside && norm(offset + edge * t - along * s) < double(kReach);
    near_edge += meet;
    EXPECT_TRUE(!meet || by_edge.count(int(n)) == 1) << n;
  }
  EXPECT_GT(near_triangle, 50);
  EXPECT_GT(near_edge, 10);
  EXPECT_LT(int(by_triangle.size()), near_triangle + 20) << "the filter is selective";
  EXPECT_LT(int(by_edge.size()), near_edge + 20);
}

// A sheet that is bent without contact has no candidates. The sheet is bent around a pipe of five
// thicknesses.
TEST(ClothContact, BentSheetHasNoCandidates) {
  constexpr Real kCell = 0.01f, kRadius = 0.05f;
  Neighborhood near;
  std::vector<Vec3> now, rest;
  for (int i = 0; i < 16; i++)
    for (int j = 0; j < 16; j++) {
      const Real angle = kCell * Real(i) / kRadius;
      rest.push_back({kCell * Real(i), kCell * Real(j), 0});
      now.push_back({kRadius * std::sin(angle), kCell * Real(j), kRadius * std::cos(angle)});
    }
  for (Vectors* v : {&near.at, &near.rest}) v->resize(now.size());
  for (std::size_t n = 0; n < now.size(); n++)
    near.index.push_back(int(n)), near.at.set(n, now[n]), near.rest.set(n, rest[n]);
  const std::size_t a = 7 * 16 + 7, b = a + 16, c = a + 1;
  int candidates = 0;
  visit_neighbors(near,
                  NearTriangle{{0.02f, 0.0095f},
                               {-1, -1, -1},
                               {1, 1, 1},
                               {now[a], now[b] - now[a], now[c] - now[a]},
                               {rest[a], rest[b] - rest[a], rest[c] - rest[a]}},
                  [&](int) { candidates++; });
  EXPECT_EQ(candidates, 0);
}

// Edges that cross push each other apart.
TEST(ClothContact, CrossingEdgesSeparate) {
  // Two triangles whose long edges cross at their midpoints with a small gap; no vertex is near.
  TriMesh mesh;
  mesh.vertices = {{-0.1f, 0, 0},      {0.1f, 0, 0},      {0, 0.1f, -0.1f},
                   {0, -0.1f, 0.008f}, {0, 0.1f, 0.008f}, {0.1f, 0, 0.108f}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  Params params;
  params.collision.thickness = 0.006;
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  for (int v = 3; v < 6; v++) state.v.z[std::size_t(model.model_vertex[std::size_t(v)])] = -0.5f;
  for (int frame = 0; frame < 20; frame++) step(Exec(1), model, state, in_vacuum(0), kFrame);
  const auto height = [&](int v) { return state.x.z[std::size_t(model.model_vertex[std::size_t(v)])]; };
  EXPECT_GT((height(3) + height(4)) / 2 - (height(0) + height(1)) / 2, 0.0055f);
}

// Contacts between layers conserve momentum and transfer some of it.
TEST(ClothContact, LayerContactKeepsMomentum) {
  TriMesh mesh = flat_sheet(10);
  const TriMesh other = make_sheet(
      {.corner = {0.004, 0.003, 0.012}, .side = {0.09, 0, 0}, .up = {0, 0.09, 0}, .columns = 9, .rows = 9});
  for (const Int3 t : other.triangles) mesh.triangles.push_back({t.x + 100, t.y + 100, t.z + 100});
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  Params params;
  params.damping = {0, 0};
  params.collision.thickness = 0.0096;
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  for (std::size_t v = 100; v < 200; v++) state.v.z[v] = -0.4f;
  const Vec3d before = momentum(model, state);
  int contacts = 0;
  for (int frame = 0; frame < 10; frame++)
    contacts += step(Exec(2), model, state, in_vacuum(0), kFrame).contacts;
  EXPECT_GT(contacts, 100);
  EXPECT_LT(norm(momentum(model, state) - before), 0.01 * norm(before));
  EXPECT_GT(state.v.z[50], -0.35f);  // some momentum was transferred
  EXPECT_LT(state.v.z[50], -0.05f);
}

// A sheet at rest on a table loads it with its weight.
TEST(ClothContact, SheetOnTableLoadsWeight) {
  Params params;
  params.collision.thickness = 0.0096;
  const Model model = must_build(flat_sheet(15), params);
  State state = make_state(model);
  for (std::size_t v = 0; v < 225; v++) state.x.z[v] = 0.004f;
  for (int frame = 0; frame < 120; frame++) step(Exec(1), model, state, on_a_table(), kFrame);
  const ObstacleLoad load = obstacle_load(state, 0, {0.07, 0.07, 0});
  EXPECT_NEAR(-load.impulse.z / kFrame / (model.total_mass * 9.81), 1, 0.01);
  EXPECT_LT(norm(load.moment), 0.002 * 0.07 * norm(load.impulse) + 1e-7);
  for (std::size_t v = 0; v < 225; v++) EXPECT_NEAR(state.x.z[v], 0.002f, 1e-4);
}

// Friction holds a sheet on a slope or lets it slide as Coulomb's law predicts.
TEST(ClothContact, FrictionOnSlope) {
  for (const double friction : {0.2, 0.5}) {  // the slope is tan 20° = 0.36
    Params params;
    params.damping.motion = 0;
    params.collision.thickness = 0.0096;
    const Model model = must_build(flat_sheet(12), params);
    State state = make_state(model);
    for (std::size_t v = 0; v < 144; v++) state.x.z[v] = 0.002f;
    const double angle = 20 * 3.14159265 / 180;
    Inputs inputs{.gravity = Vec3d{std::sin(angle), 0, -std::cos(angle)} * 9.81};
    inputs.air.density = 0;
    inputs.obstacles.push_back(plane_obstacle({0, 0, 0}, {0, 0, 1}));
    inputs.obstacles[0].friction = friction;
    for (int frame = 0; frame < 60; frame++) step(Exec(1), model, state, inputs, kFrame);
    const double expected = friction > 0.36 ? 0 : 9.81 * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(state.v.x[70], expected, 0.05 * 9.81 * std::sin(angle)) << friction;
  }
}

// A moving surface carries the sheet on it.
TEST(ClothContact, MovingSurfaceCarriesSheet) {
  TriMesh table =
      make_sheet({.corner = {-0.5, -0.5, 0}, .side = {1, 0, 0}, .up = {0, 1, 0}, .columns = 4, .rows = 4});
  Params params;
  params.collision.thickness = 0.0096;
  const Model model = must_build(flat_sheet(10), params);
  State state = make_state(model);
  for (std::size_t v = 0; v < 100; v++) state.x.z[v] = 0.002f;
  const float speed = 0.2f;
  for (int frame = 0; frame < 60; frame++) {
    TriMesh moved = table;
    for (Vec3& x : moved.vertices) x.x += speed * Real(kFrame), x.z += 0.1f * Real(kFrame);
    Inputs inputs{.gravity = {0, 0, -9.81}};
    auto surface = moving_surface(table, {}, 0);
    auto moving = *surface;
    moving.velocities.assign(table.vertices.size(), {speed, 0, 0.1f});
    inputs.obstacles.push_back(surface_obstacle(std::make_shared<const MovingSurface>(std::move(moving))));
    inputs.obstacles[0].friction = 0.6;
    step(Exec(1), model, state, inputs, kFrame);
    table = moved;
  }
  for (const std::size_t v : {0u, 45u, 99u}) {
    EXPECT_NEAR(state.v.x[v], speed, 0.01);
    EXPECT_NEAR(state.x.z[v] - table.vertices[0].z, 0.002, 5e-4);
  }
}

}  // namespace
}  // namespace turgor::cloth
