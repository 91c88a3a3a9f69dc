// Whole steps by the loops that a GPU runs, in any order, against steps of the CPU.
#include <cmath>
#include <limits>
#include <set>

#include "cloth_meshes.hpp"
#include "cloth_sheets.hpp"
#include "host_side.hpp"
#include "turgor/models/cloth/gpu_sheet.hpp"
#include "turgor/models/cloth/sheet_on.hpp"

namespace turgor::cloth {
namespace {

using lattice::Bus;
using lattice::HostSide;
using lattice::SeededRun;
using lattice::ThreadedRun;

const Exec kOne(1);
#ifdef TURGOR_SAME_BITS
constexpr bool kSameBits = true;
#else
constexpr bool kSameBits = false;  // lanes and threads may fuse other multiplications with additions
#endif

/// As put() does it with a GPU.
template <class R>
std::shared_ptr<SheetThere> put_on_host(const Model& model) {
  Rooms<HostSide<R>> rooms;
  return std::make_shared<SheetOn<HostSide<R>>>(model, rooms);
}
using Put = std::shared_ptr<SheetThere> (*)(const Model&);

struct Variant {
  Law law = Law::kSprings;
  Solver solver;
  Pattern pattern = Pattern::kRandom;
  bool gusts = true;
};

/// Two pieces of cloth, of which nothing holds the second.
Model two_pieces(const Variant& v) {
  Params params{.fabric = {.law = v.law, .poisson = v.law == Law::kSheet ? 0.2 : 0}, .solver = v.solver};
  params.collision.self = false;
  TriMesh mesh = rectangle(v.pattern, 0, 0.21, 0.13, 0.01);
  const TriMesh other = rectangle(v.pattern, 0.3, 0.4, 0.06, 0.01);
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Int3 t : other.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  return must_build(mesh, params);
}

struct Went {
  State state;
  StepReport report;
};

/// On the CPU, or where `put` says. Holds take hold, move and let go.
Went twelve_steps(const Model& model, bool gusts, Put put = nullptr) {
  KeptState state = make_state(model);
  if (put) state.step_on(put(model));
  Inputs inputs{.gravity = {1, 0, -9.81}, .measure_residual = true};
  inputs.air.velocity = {5, 1, 2};
  inputs.air.gusts = gusts ? 0.4 : 0;
  StepReport report;
  const int let_go = std::min(30, model.count - 1);
  for (int n = 0; n < 12; n++) {
    for (const int v : {0, 1, let_go})
      if (n == 2) (void)state.hold(model, v);
    if (n > 2) (void)state.move_hold(model, 0, {-0.001f * Real(n), 0, 0.002f * Real(n)});
    if (n == 8) (void)state.release(model, let_go);
    report = state.step(kOne, model, inputs, kFrame);
    EXPECT_TRUE(report.finite);
  }
  EXPECT_EQ(state->holds.size(), 2u);
  return {*state, report};
}

Real apart(const Model& model, const Vectors& a, const Vectors& b) {
  Real most = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) most = std::max(most, norm(a[v] - b[v]));
  return most;
}

void expect_steps_like_the_cpu_s(const Variant& v) {
  const Model model = two_pieces(v);
  const Went here = twelve_steps(model, v.gusts);
  const Real way = apart(model, here.state.x, model.x_rest);
  EXPECT_GT(way, 0.05f) << "m";
  std::set<std::uint64_t> hashes;
  for (const Put put : {put_on_host<ThreadedRun<1>>, put_on_host<ThreadedRun<2>>, put_on_host<ThreadedRun<8>>,
                        put_on_host<SeededRun<1>>, put_on_host<SeededRun<2>>}) {
    const Went there = twelve_steps(model, v.gusts, put);
    EXPECT_LT(apart(model, there.state.x, here.state.x), 2e-5f * way) << "m";
    EXPECT_LT(apart(model, there.state.v, here.state.v), 1e-4f * here.report.largest_speed) << "m/s";
    EXPECT_EQ(there.state.time, here.state.time);
    EXPECT_NEAR(there.report.largest_speed, here.report.largest_speed, 1e-4 * here.report.largest_speed);
    EXPECT_NEAR(there.report.residual, here.report.residual, 1e-3 * here.report.residual);
    hashes.insert(state_hash(model, there.state));
  }
  if (kSameBits) hashes.insert(state_hash(model, here.state));
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(cloth_sheet_on, steps_of_springs_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s({});
  expect_steps_like_the_cpu_s({.solver = {.method = Method::kJacobi, .sweeps = 5, .strain_limit = 0.02},
                               .pattern = Pattern::kDiagonal,
                               .gusts = false});
}

TEST(cloth_sheet_on, steps_of_a_sheet_that_bends_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s({.law = Law::kSheet});
  expect_steps_like_the_cpu_s({.law = Law::kSheet, .solver = {.sweeps = 7, .strain_limit = 0.02}});
}

TEST(cloth_sheet_on, two_steps_at_once_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s({.solver = {.integrator = Integrator::kBdf2}});
}

TEST(cloth_sheet_on, edges_with_many_triangles_count_in_the_order_of_their_numbers) {
  TriMesh mesh{.vertices = {{0, 0, 0}, {0.1f, 0, 0}}};
  for (int n = 0; n < 7; n++) {
    mesh.vertices.push_back({0.05f, 0.1f * std::cos(0.8f * Real(n)), 0.1f * std::sin(0.8f * Real(n))});
    mesh.triangles.push_back({0, 1, n + 2});
  }
  Params params{.fabric = {.law = Law::kSheet}};
  params.collision.self = false;
  const Model model = must_build(mesh, params);
  const Went here = twelve_steps(must_build(mesh, params), true, put_on_host<ThreadedRun<1>>),
             there = twelve_steps(model, true, put_on_host<SeededRun<3>>);
  EXPECT_EQ(state_hash(model, here.state), state_hash(model, there.state));
}

TEST(cloth_sheet_on, a_step_that_is_not_finite_is_undone) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2}) {
    const Model model = two_pieces({.solver = {.integrator = integrator}});
    for (const Put put : {Put(nullptr), Put(put_on_host<SeededRun<1>>)}) {
      KeptState state = make_state(model);
      if (put) state.step_on(put(model));
      EXPECT_TRUE(state.step(kOne, model, in_vacuum(), kFrame).finite);
      const Vectors before = state->x;
      EXPECT_FALSE(
          state.step(kOne, model, in_vacuum(std::numeric_limits<double>::infinity()), kFrame).finite);
      EXPECT_EQ(apart(model, state->x, before), 0) << "m";
      EXPECT_EQ(apart(model, state->v, Vectors(make_state(model).v)), 0) << "m/s";
      EXPECT_EQ(state->time, kFrame);
    }
  }
}

TEST(cloth_sheet_on, only_holds_and_four_bytes_cross_the_bus_while_nobody_looks) {
  const Model model = two_pieces({});
  KeptState state = make_state(model);
  ASSERT_TRUE(state.hold(model, 0));
  state.step_on(put_on_host<ThreadedRun<1>>(model));
  state.step(kOne, model, in_vacuum(), kFrame);
  Bus::over = Bus::back = 0;
  for (int n = 0; n < 3; n++) state.step(kOne, model, in_vacuum(), kFrame);
  EXPECT_EQ(Bus::over, 3 * (sizeof(Hold) + 4));
  EXPECT_EQ(Bus::back, 3u * 4);
  (void)state->x;
  EXPECT_EQ(Bus::back, 3 * 4 + 24 * model.mass.size());
  Bus::over = Bus::back = 0;
  state.step(kOne, model, in_vacuum(), kFrame);
  EXPECT_EQ(Bus::over, sizeof(Hold) + 4) << "it came back only to be looked at";
}

TEST(cloth_sheet_on, copies_of_a_state_step_by_themselves_on_the_same_sheet) {
  const Model model = two_pieces({});
  KeptState one = make_state(model);
  one.step_on(put_on_host<ThreadedRun<1>>(model));
  one.step(kOne, model, in_vacuum(), kFrame);
  KeptState two = one, alone = one;
  ASSERT_TRUE(two.hold(model, 3));
  for (int n = 0; n < 3; n++) {
    one.step(kOne, model, in_vacuum(), kFrame);
    two.step(kOne, model, in_vacuum(), kFrame);
  }
  for (int n = 0; n < 3; n++) alone.step(kOne, model, in_vacuum(), kFrame);
  EXPECT_EQ(state_hash(model, one), state_hash(model, alone));
  EXPECT_NE(state_hash(model, one), state_hash(model, two));
}

TEST(cloth_sheet_on, what_is_watched_is_here_after_every_step_and_what_is_written_counts) {
  const Model model = two_pieces({});
  KeptState state = make_state(model);
  state.step_on(put_on_host<ThreadedRun<1>>(model));
  Vectors& x = state.watch().x;
  const Real* memory = x.z.data();
  state.step(kOne, model, in_vacuum(), kFrame);
  const Real fallen = x.z[5];
  EXPECT_LT(fallen, 0);
  for (Real& z : x.z) z += 1;
  state.step(kOne, model, in_vacuum(), kFrame);
  EXPECT_EQ(memory, state->x.z.data());
  EXPECT_NEAR(x.z[5], 1 + 3 * fallen, 1e-5) << "m";
}

TEST(cloth_sheet_on, what_runs_on_a_gpu_is_known_before) {
  Params params;
  EXPECT_EQ(why_not_on_gpu(params, false).key, "collision");
  params.collision.self = false;
  EXPECT_EQ(why_not_on_gpu(params, false).key, "");
  EXPECT_EQ(why_not_on_gpu(params, true).key, "obstacle");
  params.solver.method = Method::kBlocks;
  EXPECT_EQ(why_not_on_gpu(params, false).key, "solver");
}

}  // namespace
}  // namespace turgor::cloth
