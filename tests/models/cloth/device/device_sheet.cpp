// Whole steps by the device loops, in any order, against steps of the CPU.
#include <cmath>
#include <limits>
#include <set>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::cloth {
namespace {

using lattice::HostBackend;
using lattice::SeededRun;
using lattice::ThreadedRun;
using lattice::Transfers;

const Exec kOne(1);
struct Variant {
  Law law = Law::kSprings;
  Solver solver;
  Pattern pattern = Pattern::kRandom;
  bool gusts = true;
};

/// Two separate sheets; the second one has no holds.
Model two_sheets(const Variant& v) {
  Params params{.fabric = {.law = v.law, .poisson = v.law == Law::kSheet ? 0.2 : 0}, .solver = v.solver};
  params.collision.self = false;
  TriMesh mesh = rectangle(v.pattern, 0, 0.21, 0.13, 0.01);
  const TriMesh other = rectangle(v.pattern, 0.3, 0.4, 0.06, 0.01);
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Int3 t : other.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  return must_build(mesh, params);
}

struct Outcome {
  State state;
  StepReport report;
  State early;  // after three steps: later, rounding errors have grown where sheets buckle and flutter
  StepReport early_report;
};

/// On the CPU, or on the backend of `put`. Vertices are held, moved and released.
Outcome twelve_steps(const Model& model, bool gusts, Put put = nullptr) {
  DeviceState state = make_state(model);
  if (put) state.use_backend(put(model));
  Inputs inputs{.gravity = {1, 0, -9.81}, .measure_residual = true};
  inputs.air.velocity = {5, 1, 2};
  inputs.air.gusts = gusts ? 0.4 : 0;
  StepReport report, early_report;
  State early;
  const int released = std::min(30, model.count - 1);
  for (int n = 0; n < 12; n++) {
    for (const int v : {0, 1, released})
      if (n == 1) (void)state.hold(model, v);
    if (n > 1) (void)state.move_hold(model, 0, {-0.001f * Real(n), 0, 0.002f * Real(n)});
    if (n == 8) (void)state.release(model, released);
    report = state.step(kOne, model, inputs, kFrame);
    EXPECT_TRUE(report.finite);
    if (n == 2) early = *state, early_report = report;
  }
  EXPECT_EQ(state->holds.size(), 2u);
  return {*state, report, early, early_report};
}

void expect_steps_match_cpu(const Variant& v) {
  const Model model = two_sheets(v);
  const Outcome host = twelve_steps(model, v.gusts);
  // A tension is (stretch − 1) times the stiffness, with a rounding error of 6e-8 in the stretch.
  const Real rounding = 1e-2f;
  const Real displacement = max_distance(model, host.early.x, model.x_rest);
  EXPECT_GT(displacement, 0.002f) << "m";
  std::set<std::uint64_t> hashes;
  for (const Put put : kPuts) {
    const Outcome device = twelve_steps(model, v.gusts, put);
    const StepReport &a = device.early_report, &b = host.early_report;
    EXPECT_LT(max_distance(model, device.early.x, host.early.x), rounding * displacement) << "m";
    EXPECT_LT(max_distance(model, device.early.v, host.early.v), rounding * b.largest_speed) << "m/s";
    EXPECT_NEAR(a.largest_speed, b.largest_speed, rounding * b.largest_speed) << "m/s";
    EXPECT_NEAR(a.residual, b.residual, 1e-2 * b.residual);
    EXPECT_EQ(device.state.time, host.state.time);
    hashes.insert(state_hash(model, device.state));
  }
  if (kSameBits) hashes.insert(state_hash(model, host.state));
  EXPECT_EQ(hashes.size(), 1u);
}

// Steps of springs match the CPU in any order of the loops.
TEST(ClothDeviceSheet, SpringsMatchCpuInAnyOrder) {
  expect_steps_match_cpu({});
  expect_steps_match_cpu({.solver = {.method = Method::kJacobi, .sweeps = 5, .strain_limit = 0.02},
                          .pattern = Pattern::kDiagonal,
                          .gusts = false});
}

// Steps of a sheet that bends match the CPU in any order of the loops.
TEST(ClothDeviceSheet, BendingMatchesCpuInAnyOrder) {
  expect_steps_match_cpu({.law = Law::kSheet});
  expect_steps_match_cpu({.law = Law::kSheet, .solver = {.sweeps = 7, .strain_limit = 0.02}});
}

// BDF2 steps match the CPU in any order of the loops.
TEST(ClothDeviceSheet, Bdf2MatchesCpuInAnyOrder) {
  expect_steps_match_cpu({.solver = {.integrator = Integrator::kBdf2}});
}

/// A sheet that is pushed together over itself with random velocities: layers press and rub.
Outcome crumpled(const Model& model, int steps, Put put = nullptr) {
  DeviceState state = make_state(model);
  shake(model, state.change().v, 4);
  if (put) state.use_backend(put(model));
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

// Contacts between layers match the CPU in any order of the loops, without crossings.
TEST(ClothDeviceSheet, LayersMatchCpuInAnyOrder) {
  for (const Law law : {Law::kSprings, Law::kSheet}) {
    Params params{.fabric = {.law = law}};
    params.collision.thickness = 0.0096;
    const Model model = must_build(flat_sheet(15), params);
    ASSERT_TRUE(model.large.triangles.empty());
    constexpr int kSteps = 10;
    const Outcome host = crumpled(model, kSteps);
    EXPECT_GT(host.report.contacts, 50);
    EXPECT_GT(host.report.in_impact_zone, 3) << "law " << int(law);
    EXPECT_GT(host.report.contact_iterations, 3);
    std::set<std::uint64_t> hashes;
    for (const Put put : kPuts) {
      const Outcome device = crumpled(model, kSteps, put);
      EXPECT_EQ(self_distance(kOne, model, device.state).crossings, 0);
      hashes.insert(state_hash(model, device.state));
      if (!kSameBits) continue;
      EXPECT_EQ(device.report.contacts, host.report.contacts);
      EXPECT_EQ(device.report.in_impact_zone, host.report.in_impact_zone);
      EXPECT_EQ(device.report.contact_iterations, host.report.contact_iterations);
      EXPECT_EQ(device.state.contacts.begin, host.state.contacts.begin);
      EXPECT_EQ(device.state.contacts.item, host.state.contacts.item);
      EXPECT_EQ(device.state.contacts.touched, host.state.contacts.touched);
    }
    if (kSameBits) hashes.insert(state_hash(model, host.state));
    EXPECT_EQ(hashes.size(), 1u) << "law " << int(law);
  }
}

// Layers in contact need no download of the state as long as CCD finds no pair.
TEST(ClothDeviceSheet, RestingLayersStayOnDevice) {
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
  state.use_backend(put_on_host<ThreadedRun<2>>(model));
  state.step(kOne, model, in_vacuum(0), kFrame);
  for (int n = 0; n < 5; n++) {
    Transfers::downloaded = 0;
    const StepReport report = state.step(kOne, model, in_vacuum(0), kFrame);
    EXPECT_GT(report.contacts, 100);
    EXPECT_EQ(report.in_impact_zone, 0);
    EXPECT_LT(Transfers::downloaded, 100u) << "bytes: neither positions nor velocities";
  }
  EXPECT_GT(self_distance(kOne, model, state).smallest, 0.99 * params.collision.thickness) << "m";
}

// Bends at edges of many triangles are summed in a fixed order.
TEST(ClothDeviceSheet, SharedEdgesAreDeterministic) {
  TriMesh mesh{.vertices = {{0, 0, 0}, {0.1f, 0, 0}}};
  for (int n = 0; n < 7; n++) {
    mesh.vertices.push_back({0.05f, 0.1f * std::cos(0.8f * Real(n)), 0.1f * std::sin(0.8f * Real(n))});
    mesh.triangles.push_back({0, 1, n + 2});
  }
  Params params{.fabric = {.law = Law::kSheet}};
  params.collision.self = false;
  const Model model = must_build(mesh, params);
  const Outcome host = twelve_steps(must_build(mesh, params), true, put_on_host<ThreadedRun<1>>),
                device = twelve_steps(model, true, put_on_host<SeededRun<3>>);
  EXPECT_EQ(state_hash(model, host.state), state_hash(model, device.state));
}

// A step that is not finite is undone, on the CPU and on the device.
TEST(ClothDeviceSheet, NonFiniteStepIsUndone) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2}) {
    const Model model = two_sheets({.solver = {.integrator = integrator}});
    for (const Put put : {Put(nullptr), Put(put_on_host<SeededRun<1>>)}) {
      DeviceState state = make_state(model);
      if (put) state.use_backend(put(model));
      EXPECT_TRUE(state.step(kOne, model, in_vacuum(), kFrame).finite);
      const Vectors before = state->x;
      EXPECT_FALSE(
          state.step(kOne, model, in_vacuum(std::numeric_limits<double>::infinity()), kFrame).finite);
      EXPECT_EQ(max_distance(model, state->x, before), 0) << "m";
      EXPECT_EQ(max_distance(model, state->v, Vectors(make_state(model).v)), 0) << "m/s";
      EXPECT_EQ(state->time, kFrame);
    }
  }
}

// A step whose state is not read uploads the holds and transfers four more bytes each displacement.
TEST(ClothDeviceSheet, UnreadStepTransfersHoldsOnly) {
  const Model model = two_sheets({});
  DeviceState state = make_state(model);
  ASSERT_TRUE(state.hold(model, 0));
  state.use_backend(put_on_host<ThreadedRun<1>>(model));
  state.step(kOne, model, in_vacuum(), kFrame);
  Transfers::uploaded = Transfers::downloaded = 0;
  for (int n = 0; n < 3; n++) state.step(kOne, model, in_vacuum(), kFrame);
  EXPECT_EQ(Transfers::uploaded, 3 * (sizeof(Hold) + 4));
  EXPECT_EQ(Transfers::downloaded, 3u * 4);
  (void)state->x;
  EXPECT_EQ(Transfers::downloaded, 3 * 4 + 24 * model.mass.size());
  Transfers::uploaded = Transfers::downloaded = 0;
  state.step(kOne, model, in_vacuum(), kFrame);
  EXPECT_EQ(Transfers::uploaded, sizeof(Hold) + 4) << "a read downloads the state but does not upload it";
}

// Copies of a state step independently on the same device sheet.
TEST(ClothDeviceSheet, CopiedStatesStepIndependently) {
  const Model model = two_sheets({});
  DeviceState one = make_state(model);
  one.use_backend(put_on_host<ThreadedRun<1>>(model));
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

// A watched state is downloaded after every step; writes to it are uploaded.
TEST(ClothDeviceSheet, WatchedStateIsSynchronized) {
  const Model model = two_sheets({});
  DeviceState state = make_state(model);
  state.use_backend(put_on_host<ThreadedRun<1>>(model));
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

double bytes_per_vertex(const Collision& collision) {
  const Model model = must_build(flat_sheet(100), {.collision = collision});
  DeviceAllocator<HostBackend<SeededRun<1>>> allocator;
  const DeviceSheet<HostBackend<SeededRun<1>>> sheet(model, allocator);
  return double(allocator.bytes) / model.count;
}

// The device memory per vertex is that of the documentation.
TEST(ClothDeviceSheet, MemoryMatchesDocumentation) {
  EXPECT_NEAR(bytes_per_vertex({.self = false}), 375, 5) << "bytes";
  EXPECT_NEAR(bytes_per_vertex({.thickness = 0.0096}), 418, 5) << "bytes";
  EXPECT_NEAR(bytes_per_vertex({.thickness = 0.005}), 636, 5) << "bytes, in large triangles";
}

// why_not_on_gpu names the parameter that a GPU does not support.
TEST(ClothDeviceSheet, ReportsUnsupportedParameters) {
  Params params;
  EXPECT_EQ(why_not_on_gpu(params).key, "");
  params.solver.method = Method::kTwoLevel;
  EXPECT_EQ(why_not_on_gpu(params).key, "solver");
}

}  // namespace
}  // namespace turgor::cloth
