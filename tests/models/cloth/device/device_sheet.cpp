// Whole steps by the loops that a GPU runs, in any order, against steps of the CPU.
#include <cmath>
#include <limits>
#include <set>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace turgor::cloth {
namespace {

using lattice::Bus;
using lattice::HostSide;
using lattice::SeededRun;
using lattice::ThreadedRun;

const Exec kOne(1);
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
  State early;  // after three steps: later on roundings have grown, where sheets buckle and flutter
  StepReport early_report;
};

/// On the CPU, or where `put` says. Holds take hold, move and let go.
Went twelve_steps(const Model& model, bool gusts, Put put = nullptr) {
  DeviceState state = make_state(model);
  if (put) state.step_on(put(model));
  Inputs inputs{.gravity = {1, 0, -9.81}, .measure_residual = true};
  inputs.air.velocity = {5, 1, 2};
  inputs.air.gusts = gusts ? 0.4 : 0;
  StepReport report, early_report;
  State early;
  const int let_go = std::min(30, model.count - 1);
  for (int n = 0; n < 12; n++) {
    for (const int v : {0, 1, let_go})
      if (n == 1) (void)state.hold(model, v);
    if (n > 1) (void)state.move_hold(model, 0, {-0.001f * Real(n), 0, 0.002f * Real(n)});
    if (n == 8) (void)state.release(model, let_go);
    report = state.step(kOne, model, inputs, kFrame);
    EXPECT_TRUE(report.finite);
    if (n == 2) early = *state, early_report = report;
  }
  EXPECT_EQ(state->holds.size(), 2u);
  return {*state, report, early, early_report};
}

void expect_steps_like_the_cpu_s(const Variant& v) {
  const Model model = two_pieces(v);
  const Went here = twelve_steps(model, v.gusts);
  // A tension is what is left of a stretch less 1, times its stiffness, of which 6e-8 is rounded off.
  const Real rounding = 1e-2f;
  const Real way = apart(model, here.early.x, model.x_rest);
  EXPECT_GT(way, 0.002f) << "m";
  std::set<std::uint64_t> hashes;
  for (const Put put : kPuts) {
    const Went there = twelve_steps(model, v.gusts, put);
    const StepReport &a = there.early_report, &b = here.early_report;
    EXPECT_LT(apart(model, there.early.x, here.early.x), rounding * way) << "m";
    EXPECT_LT(apart(model, there.early.v, here.early.v), rounding * b.largest_speed) << "m/s";
    EXPECT_NEAR(a.largest_speed, b.largest_speed, rounding * b.largest_speed) << "m/s";
    EXPECT_NEAR(a.residual, b.residual, 1e-2 * b.residual);
    EXPECT_EQ(there.state.time, here.state.time);
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

/// A sheet that is pushed together over itself, its vertices thrown about: layers press and rub.
Went crumpled(const Model& model, int steps, Put put = nullptr) {
  DeviceState state = make_state(model);
  shake(model, state.change().v, 4);
  if (put) state.step_on(put(model));
  for (const int v : {0, 1, 2}) EXPECT_TRUE(state.hold(model, v));
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.air.velocity = {-8, 1, 3};
  inputs.air.gusts = 0.5;
  StepReport report, most;
  for (int n = 0; n < steps; n++) {
    for (const int v : {0, 1, 2})
      (void)state.move_hold(model, v, {0.004f * Real(n), 0.002f * Real(v), 0.02f * std::sin(0.5f * Real(n))});
    report = state.step(kOne, model, inputs, kFrame);
    EXPECT_TRUE(report.finite);
    most.contacts = std::max(most.contacts, report.contacts);
    most.in_impact_zone = std::max(most.in_impact_zone, report.in_impact_zone);
    most.contact_iterations = std::max(most.contact_iterations, report.contact_iterations);
  }
  return {*state, most, {}, {}};
}

TEST(cloth_sheet_on, layers_stay_apart_in_any_order_as_on_the_cpu) {
  for (const Law law : {Law::kSprings, Law::kSheet}) {
    Params params{.fabric = {.law = law}};
    params.collision.thickness = 0.0096;
    const Model model = must_build(flat_sheet(15), params);
    ASSERT_TRUE(model.coarse.triangles.empty());
    constexpr int kSteps = 10;
    const Went here = crumpled(model, kSteps);
    EXPECT_GT(here.report.contacts, 50);
    EXPECT_GT(here.report.in_impact_zone, 3) << "law " << int(law);
    EXPECT_GT(here.report.contact_iterations, 3);
    std::set<std::uint64_t> hashes;
    for (const Put put : kPuts) {
      const Went there = crumpled(model, kSteps, put);
      EXPECT_EQ(self_distance(kOne, model, there.state).crossings, 0);
      hashes.insert(state_hash(model, there.state));
      if (!kSameBits) continue;
      EXPECT_EQ(there.report.contacts, here.report.contacts);
      EXPECT_EQ(there.report.in_impact_zone, here.report.in_impact_zone);
      EXPECT_EQ(there.report.contact_iterations, here.report.contact_iterations);
      EXPECT_EQ(there.state.contacts.begin, here.state.contacts.begin);
      EXPECT_EQ(there.state.contacts.item, here.state.contacts.item);
      EXPECT_EQ(there.state.contacts.touched, here.state.contacts.touched);
    }
    if (kSameBits) hashes.insert(state_hash(model, here.state));
    EXPECT_EQ(hashes.size(), 1u) << "law " << int(law);
  }
}

TEST(cloth_sheet_on, layers_that_lie_on_each_other_stay_there_as_long_as_nothing_would_pass_through) {
  Params params;
  params.collision.thickness = 0.0096;
  TriMesh mesh = flat_sheet(12);
  const int count = int(mesh.vertices.size()), triangles = int(mesh.triangles.size());
  for (int v = 0; v < count; v++)
    mesh.vertices.push_back(mesh.vertices[std::size_t(v)] + Vec3{0, 0, 0.0105f});
  for (int t = 0; t < triangles; t++)
    mesh.triangles.push_back(mesh.triangles[std::size_t(t)] + Int3{count, count, count});
  const Model model = must_build(mesh, params);
  DeviceState state = make_state(model);
  for (int v = 0; v < model.count; v++)
    state.change().v.z[std::size_t(v)] = model.x_rest.z[std::size_t(v)] > 0 ? -0.5f : 0;
  state.step_on(put_on_host<ThreadedRun<2>>(model));
  state.step(kOne, model, in_vacuum(0), kFrame);
  for (int n = 0; n < 5; n++) {
    Bus::back = 0;
    const StepReport report = state.step(kOne, model, in_vacuum(0), kFrame);
    EXPECT_GT(report.contacts, 100);
    EXPECT_EQ(report.in_impact_zone, 0);
    EXPECT_LT(Bus::back, 100u) << "bytes: no place and no velocity";
  }
  EXPECT_GT(self_distance(kOne, model, state).smallest, 0.99 * params.collision.thickness) << "m";
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
      DeviceState state = make_state(model);
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
  DeviceState state = make_state(model);
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
  DeviceState one = make_state(model);
  one.step_on(put_on_host<ThreadedRun<1>>(model));
  one.step(kOne, model, in_vacuum(), kFrame);
  DeviceState two = one, alone = one;
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
  DeviceState state = make_state(model);
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

double bytes_a_vertex(const Collision& collision) {
  const Model model = must_build(flat_sheet(100), {.collision = collision});
  DeviceAllocator<HostSide<SeededRun<1>>> rooms;
  const DeviceSheet<HostSide<SeededRun<1>>> sheet(model, rooms);
  return double(rooms.bytes) / model.count;
}

TEST(cloth_sheet_on, memory_is_what_the_documents_say) {
  EXPECT_NEAR(bytes_a_vertex({.self = false}), 375, 5) << "bytes";
  EXPECT_NEAR(bytes_a_vertex({.thickness = 0.0096}), 418, 5) << "bytes";
  EXPECT_NEAR(bytes_a_vertex({.thickness = 0.005}), 560, 5) << "bytes, in large triangles";
}

TEST(cloth_sheet_on, what_runs_on_a_gpu_is_known_before) {
  Params params;
  EXPECT_EQ(why_not_on_gpu(params).key, "");
  params.solver.method = Method::kBlocks;
  EXPECT_EQ(why_not_on_gpu(params).key, "solver");
}

}  // namespace
}  // namespace turgor::cloth
