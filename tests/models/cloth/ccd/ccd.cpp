#include "turgor/models/cloth/ccd/ccd.hpp"

#include "tests/models/cloth/sheets.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {
namespace {

constexpr double kThickness = 0.0096;

// A vertex hits a triangle at any speed and misses it beside the triangle.
TEST(ClothCcd, VertexTriangle_AnySpeed) {
  const std::array<Vec3d, 4> x{Vec3d{0.2, 0.2, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const double speed : {0.11, 1.0, 1000.0})
    EXPECT_TRUE(comes_too_near(x, {Vec3d{0, 0, -speed}, {}, {}, {}}, false, kThickness)) << speed;
  EXPECT_FALSE(comes_too_near(x, {Vec3d{0, 0, -0.09}, {}, {}, {}}, false, kThickness)) << "stops before";
  EXPECT_FALSE(comes_too_near(x, {Vec3d{2, 0, -0.2}, {}, {}, {}}, false, kThickness)) << "passes beside";
  const Vec3d all{3, -2, -5};
  EXPECT_FALSE(comes_too_near(x, {all, all, all, all}, false, kThickness)) << "rigid motion";
  EXPECT_TRUE(comes_too_near(x, {all + Vec3d{0, 0, -0.2}, all, all, all}, false, kThickness));
}

// Two edges hit where they cross and miss beyond their ends.
TEST(ClothCcd, EdgeEdge_HitsAndMisses) {
  const std::array<Vec3d, 4> x{Vec3d{-1, 0, 0.1}, {1, 0, 0.1}, {0, -1, 0}, {0, 1, 0}};
  const Vec3d down{0, 0, -0.2}, sideways{3, 0, -0.2};
  EXPECT_TRUE(comes_too_near(x, {down, down, {}, {}}, true, kThickness));
  EXPECT_FALSE(comes_too_near(x, {sideways, sideways, {}, {}}, true, kThickness));
  EXPECT_TRUE(comes_too_near(x, {down, {}, {}, -down}, true, kThickness)) << "both rotate";
  EXPECT_FALSE(comes_too_near(x, {down, {}, {}, down}, true, kThickness)) << "one rotates away";
}

// The local search around a changed vertex finds a CCD pair exactly if the full search does. One vertex of a
// rough sheet is pulled far out and moves. Its edges hit primitives near their other ends, where no vertex
// moves.
TEST(ClothCcd, LocalSearchMatchesFullSearch) {
  Params params;
  params.collision.thickness = 0.004;
  const Model model = must_build(flat_sheet(16), params);
  const Exec exec(1);
  State state = make_state(model);
  CcdWorkspace& ccd = state.ccd;
  Vectors &before = state.system.previous, &displacement = state.system.force;  // as ccd_motion uses them
  before = state.x;
  shake(model, before, 0.004);
  RandomNumbers next{7};
  int hits = 0, tries = 0;
  for (int v = 0; v < model.count; v++)
    for (int n = 0; n < 3; n++, tries++) {
      const double x = next(), y = next(), z = next();
      const Vec3 position = before[std::size_t(v)];
      before.add(std::size_t(v), {0, 0, 0.1f});
      displacement.set(std::size_t(v), Vec3(Vec3d{x, y, z} * 0.08));
      ccd.in_impact_zone = {v}, ccd.zone = {0};
      measure_triangles(exec, model, state);
      build_boxes(exec, model, state);
      mark_changed(exec, model, {v}, ccd);
      const auto finds = [&](bool changed) {
        ccd.ccd_pairs.clear();
        return find_ccd_pairs(exec, model, state, changed);
      };
      const bool expected = finds(false);
      EXPECT_EQ(finds(true), expected) << v;
      hits += expected;
      displacement.set(std::size_t(v), {}), before.set(std::size_t(v), position);
    }
  EXPECT_GT(hits, 40);
  EXPECT_LT(hits, tries / 2);
}

/// Worst values of a run.
struct RunSummary {
  int crossed_frames = 0, in_impact_zone = 0;
  double smallest =
      INFINITY;  // smallest distance between vertices that are not close at rest, at the end [m]
};

void record(const Exec& exec, const Model& model, const State& state, const StepReport& report,
            RunSummary& summary) {
  ASSERT_TRUE(report.finite);
  summary.in_impact_zone += report.in_impact_zone;
  summary.crossed_frames += !crossing_triangles(exec, model_surface(model, state)).empty();
}

TriMesh together(TriMesh a, const TriMesh& b) {
  const int n = int(a.vertices.size());
  for (const Int3 t : b.triangles) a.triangles.push_back({t.x + n, t.y + n, t.z + n});
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  return a;
}

// The motion that resolve_ccd accepts is free of collisions for a full search too. Ten layers are pressed to
// a tenth of their height, so zones grow over many rounds, which search only around their borders.
TEST(ClothCcd, AcceptedMotionPassesFullSearch) {
  constexpr int kLayers = 10, kSide = 14;
  TriMesh stack;
  for (int layer = 0; layer < kLayers; layer++) {
    TriMesh sheet = flat_sheet(kSide);
    for (Vec3& x : sheet.vertices)
      x += Vec3{0.003f * Real(layer), 0.002f * Real(layer), 0.008f * Real(layer)};
    stack = together(std::move(stack), sheet);
  }
  Params params;
  params.collision.thickness = 0.004;
  const Model model = must_build(stack, params);
  for (const int threads : {1, 2, 8}) {
    const Exec exec(threads);
    State state = make_state(model);
    state.ccd.steps_until_check = -1;
    Vectors pressed = state.x;
    shake(model, pressed, 0.001);
    for (std::size_t v = 0; v < std::size_t(model.count); v++) {
      const bool is_upper_half = state.x.y[v] > 0.07f;
      if (is_upper_half) pressed.z[v] *= 0.1f;
    }
    state.system.previous = state.x, state.x = pressed;
    const int in_impact_zone = resolve_ccd(exec, model, state);
    EXPECT_GT(in_impact_zone, model.count / 3);
    EXPECT_LT(in_impact_zone, model.count);
    measure_triangles(exec, model, state);
    build_boxes(exec, model, state);
    EXPECT_FALSE(find_ccd_pairs(exec, model, state, false)) << threads;
  }
}

// Two colliding sheets do not pass through each other and keep their momentum at any speed.
TEST(ClothCcd, CollidingSheetsKeepMomentum) {
  for (const float speed : {3.0f, 30.0f, 300.0f}) {  // up to 5 m per frame: a thousand thicknesses
    const TriMesh other = make_sheet(
        {.corner = {0.013, 0.006, 0.03}, .side = {0.09, 0, 0}, .up = {0, 0.09, 0}, .columns = 9, .rows = 9});
    Params params;
    params.damping = {0, 0};
    params.collision.thickness = kThickness;
    const Model model = must_build(together(flat_sheet(12), other), params);
    State state = make_state(model);
    for (std::size_t v = 144; v < 244; v++) state.v.z[v] = -speed;
    const Vec3d before = momentum(model, state);
    RunSummary summary;
    for (int frame = 0; frame < 10; frame++) {
      record(Exec(2), model, state, step(Exec(2), model, state, in_vacuum(0), kFrame), summary);
      if (frame == 0) {  // later, strongly stretched springs would need more sweeps
        EXPECT_LT(norm(momentum(model, state) - before), 1e-5 * norm(before)) << speed;
      }
    }
    EXPECT_EQ(summary.crossed_frames, 0) << speed;
    EXPECT_LT(state.v.z[60], -0.1f * speed) << "the struck sheet moves along";
    EXPECT_GT(summary.in_impact_zone, 0) << speed;
  }
}

// A drape whose corner is pulled away quickly never crosses itself. A sheet rests on a ball and a table; its
// corner is pulled away over it, faster than the sheet can follow.
TEST(ClothCcd, PulledDrapeNeverCrossesItself) {
  for (const double speed : {0.3, 3.0}) {
    constexpr int kSide = 34;
    Params params{.fabric = {.density = 0.1, .warp = 300, .weft = 300, .shear = 60, .bend = 1}};
    params.collision = {.thickness = kThickness, .iterations = 20};
    const Model model = must_build(flat_sheet(kSide), params);
    State state = make_state(model);
    for (std::size_t v = 0; v < std::size_t(model.count); v++) state.x.add(v, {-0.165f, -0.165f, 0.13f});
    const contact::Shape ball = contact::Sphere{.radius = 0.06};
    const contact::Pose pose{.position = {0, 0, 0.06}};
    Inputs inputs{.gravity = {0, 0, -9.81}};
    inputs.obstacles = {plane_obstacle({0, 0, 0}, {0, 0, 1}),
                        contact::cloth_obstacle(ball, pose, pose, kFrame)};
    const Exec exec(2);
    RunSummary summary;
    for (int frame = 0; frame < 60; frame++)
      record(exec, model, state, step(exec, model, state, inputs, kFrame), summary);
    ASSERT_TRUE(hold(model, state, 0));
    const Vec3 from = state.x[std::size_t(model.model_vertex[0])];
    for (int frame = 1; frame <= 20; frame++) {
      const Real travel = Real(speed * kFrame * frame);
      ASSERT_TRUE(move_hold(model, state, 0, from + Vec3{travel, travel, travel / 3}));
      record(exec, model, state, step(exec, model, state, inputs, kFrame), summary);
    }
    EXPECT_EQ(summary.crossed_frames, 0) << speed;
    const SelfDistance d = self_distance(exec, model, state);
    RecordProperty("smallest_mm_at_" + std::to_string(int(speed)), std::to_string(d.smallest * 1e3));
    EXPECT_GT(d.smallest, 0) << speed;
    EXPECT_GT(summary.in_impact_zone, 0) << speed << ": CCD was not exercised";
  }
}

// A sheet that is crushed between plates never crosses itself. A plate presses a standing sheet into folds,
// which must not pass through each other.
TEST(ClothCcd, CrushedSheetNeverCrossesItself) {
  Params params{.fabric = {.warp = 300, .weft = 300, .shear = 60, .bend = 1}};
  params.collision.thickness = kThickness;
  const Model model = must_build(flat_sheet(20), params);
  State state = make_state(model);
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    const Vec3 x = state.x[v];
    state.x.set(v, {x.x, 0.01f * std::sin(30 * x.y), x.y + 0.003f});
  }
  const Exec exec(2);
  RunSummary summary;
  for (int frame = 0; frame < 90; frame++) {
    const double top = std::max(0.03, 0.2 - 0.3 * kFrame * frame);
    Inputs inputs{.gravity = {0, 0, -9.81}};
    inputs.obstacles = {plane_obstacle({0, 0, 0}, {0, 0, 1}), plane_obstacle({0, 0, top}, {0, 0, -1})};
    record(exec, model, state, step(exec, model, state, inputs, kFrame), summary);
  }
  EXPECT_EQ(summary.crossed_frames, 0);
  Real high = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) high = std::max(high, state.x.z[v]);
  EXPECT_LT(high, 0.05f) << "the plate presses the sheet down";
  RecordProperty("smallest_mm", std::to_string(self_distance(exec, model, state).smallest * 1e3));
}

// Random steps never produce a crossing.
TEST(ClothCcd, RandomStepsNeverCross) {
  Params params;
  params.collision.thickness = kThickness;
  const Model model = must_build(flat_sheet(9), params);
  State state = make_state(model);
  const Exec exec(1);
  RandomNumbers next{11};
  RunSummary summary;
  for (int n = 0; n < 600; n++)
    record(exec, model, state, storm_step(exec, model, state, next, false), summary);
  EXPECT_EQ(summary.crossed_frames, 0);
  EXPECT_GT(summary.in_impact_zone, 600);
}

// Impact zones have the same bits on one, two and eight threads.
TEST(ClothCcd, EqualBitsOnAnyThreads) {
  std::uint64_t expected = 0;
  for (const int threads : {1, 2, 8}) {
    Params params;
    params.collision.thickness = kThickness;
    const Model model = must_build(flat_sheet(24), params);
    State state = make_state(model);
    const Exec exec(threads);
    int in_impact_zone = 0;
    for (const int v : {0, 23, 300}) ASSERT_TRUE(hold(model, state, v));
    for (int frame = 1; frame <= 6; frame++) {
      for (const int v : {0, 23, 300})
        ASSERT_TRUE(
            move_hold(model, state, v, Vec3{0.1f, 0.1f * std::sin(Real(frame + v)), 0.02f * Real(frame)}));
      in_impact_zone += step(exec, model, state, in_vacuum(), kFrame).in_impact_zone;
    }
    EXPECT_GT(in_impact_zone, 0);
    if (threads == 1) expected = state_hash(model, state);
    EXPECT_EQ(state_hash(model, state), expected) << threads;
  }
}

// CCD does not act on a sheet that crosses itself initially.
TEST(ClothCcd, InitialCrossingDisablesCcd) {
  const TriMesh other = make_sheet(
      {.corner = {0.053, -0.02, -0.05}, .side = {0, 0.12, 0}, .up = {0, 0, 0.1}, .columns = 9, .rows = 9});
  Params params;
  params.collision.thickness = 0.009;
  const Model model = must_build(together(flat_sheet(10), other), params);
  State state = make_state(model);
  for (std::size_t v = 100; v < 200; v++) state.v.z[v] = 2;
  int in_impact_zone = 0;
  for (int frame = 0; frame < 5; frame++)
    in_impact_zone += step(Exec(1), model, state, in_vacuum(0), kFrame).in_impact_zone;
  EXPECT_EQ(in_impact_zone, 0);
}

// Pairs in contact at rest are ignored, so that a sheet falls freely beside its neighbor.
TEST(ClothCcd, PairsInContactAtRestAreIgnored) {
  const TriMesh other = make_sheet(  // its first column coincides with the last one of the other sheet
      {.corner = {0.09, 0, 0}, .side = {0.09, 0, 0}, .up = {0, 0.09, 0}, .columns = 9, .rows = 9});
  Params params;
  params.collision.thickness = kThickness;
  const Model model = must_build(together(flat_sheet(10), other), params);
  State state = make_state(model);
  for (int v = 0; v < 100; v++) ASSERT_TRUE(hold(model, state, v));
  int in_impact_zone = 0;
  for (int frame = 0; frame < 12; frame++)
    in_impact_zone += step(Exec(1), model, state, in_vacuum(), kFrame).in_impact_zone;
  EXPECT_EQ(in_impact_zone, 0);
  const Real fallen = state.x.z[std::size_t(model.model_vertex[155])];
  EXPECT_NEAR(fallen, -9.81 * 0.2 * 0.2 / 2, 0.03) << "not attached to the other sheet";
}

// A stack of ten folds that slides apart never crosses itself. Folded with coincident corners, which spheres
// on spheres do not support: the stack slides apart.
TEST(ClothCcd, SlidingFoldsNeverCross) {
  constexpr int kAlong = 12, kWidth = 9, kLength = 10 * kAlong;
  const TriMesh strip = make_sheet({.side = {0.01 * (kLength - 1), 0, 0},
                                    .up = {0, 0.01 * (kWidth - 1), 0},
                                    .columns = kLength - 1,
                                    .rows = kWidth - 1});
  Params params;
  params.collision.thickness = kThickness;
  const Model model = must_build(strip, params);
  State state = make_state(model);
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    const Vec3 x = state.x[v];
    const int column = int(std::lround(x.x / 0.01f)), layer = column / kAlong, along = column % kAlong;
    const int position_in_layer = layer % 2 == 0 ? along : kAlong - 1 - along;
    state.x.set(v, {0.01f * Real(position_in_layer), x.y, 0.003f + Real(1.3 * kThickness) * Real(layer)});
  }
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.obstacles = {plane_obstacle({0, 0, 0}, {0, 0, 1})};
  const Exec exec(2);
  RunSummary summary;
  for (int frame = 0; frame < 120; frame++)
    record(exec, model, state, step(exec, model, state, inputs, kFrame), summary);
  EXPECT_EQ(summary.crossed_frames, 0);
  EXPECT_GT(summary.in_impact_zone, 0);
  RecordProperty("smallest_mm", std::to_string(self_distance(exec, model, state).smallest * 1e3));
}

}  // namespace
}  // namespace turgor::cloth
