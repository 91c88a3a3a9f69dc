#include "app/bench_cloth.hpp"

#include "app/machine.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/cloth/build/sheet.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/models/cloth/measure.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor {

namespace {

using namespace cloth;

constexpr double kDt = 1.0 / 60, kSpacing = 0.01;
constexpr int kWarmFrames = 30, kFrames = 21;

struct BenchSheet {
  Model model;
  State state;
  Inputs inputs{.gravity = {0, 0, -9.81}};
};

BenchSheet sheet(const Exec& exec, int side, Vec3d corner, bool self) {
  Params params;
  params.solver = {.method = Method::kChebyshev, .sweeps = 8};
  params.collision = {.self = self, .thickness = 0.96 * kSpacing};
  const double length = kSpacing * (side - 1);
  const TriMesh mesh = make_sheet({.corner = corner,
                                   .side = {length, 0, 0},
                                   .up = {0, length, 0},
                                   .columns = side - 1,
                                   .rows = side - 1});
  BenchSheet result{.model = build(exec, mesh, params).value(), .state = {}};
  result.state = make_state(result.model);
  return result;
}

/// A square sheet in gusts, held along its first column.
BenchSheet flag(const Exec& exec, int side, bool self) {
  BenchSheet flag = sheet(exec, side, {}, self);
  for (int j = 0; j < side; j++) (void)hold(flag.model, flag.state, j * side);
  flag.inputs.air.velocity = {6, 0, 2};
  flag.inputs.air.gusts = 0.3;
  return flag;
}

double frame_ms(const Exec& exec, BenchSheet& sheet) {
  return median_ms(kFrames, [&] { step(exec, sheet.model, sheet.state, sheet.inputs, kDt); });
}

double gpu_frame_ms(const Gpu& gpu, const BenchSheet& sheet) {
  const auto backend = put(gpu, sheet.model);
  if (!backend) return 0;
  DeviceState state = sheet.state;
  state.use_backend(*backend);
  const auto frame = [&] { state.step(Exec(1), sheet.model, sheet.inputs, kDt); };
  frame();
  return median_ms(kFrames, frame);
}

ClothFrameRow measure_frames(const Exec& exec, double bandwidth, int side) {
  ClothFrameRow row{.vertices = side * side};
  const Exec one(1);
  for (const bool self : {false, true}) {
    BenchSheet sheet = flag(exec, side, self);
    for (int n = 0; n < kWarmFrames; n++) step(exec, sheet.model, sheet.state, sheet.inputs, kDt);
    (self ? row.self_one : row.single_one) = frame_ms(one, sheet);
    (self ? row.self : row.alone) = frame_ms(exec, sheet);
    const Result<Gpu> gpu = open_gpu();
    if (gpu) (self ? row.gpu_self : row.gpu_alone) = gpu_frame_ms(*gpu, sheet);
    if (!self) continue;
    row.contacts_per_vertex = double(sheet.state.contacts.list.size()) / row.vertices;
    row.bytes_per_vertex = double(memory_bytes(sheet.model, sheet.state)) / row.vertices;
    row.sweep = median_ms(kFrames, [&] { sweep(exec, sheet.model, sheet.state, 1); });
    // Bytes of one sweep. Per off-diagonal entry of half the matrix: two stiffness numbers. Per far row: one
    // bending number. Per vertex: position, force, six numbers of the diagonal, and the velocity change read
    // and written.
    const double bytes = 8.0 * double(sheet.model.rows.stiffness.size()) +
                         4.0 * double(sheet.model.far_rows.bend.size()) + 80.0 * row.vertices;
    row.bandwidth_fraction = bytes / (row.sweep * 1e-3) / bandwidth;
  }
  return row;
}

ClothDrapeRow measure_drape(const Exec& exec) {
  constexpr int kSide = 100;
  BenchSheet drape = sheet(exec, kSide, {-0.5, -0.5, 0.31}, true);
  const contact::Shape ball = contact::Sphere{.radius = 0.15};
  const contact::Pose pose{.position = {0, 0, 0.15}};
  drape.inputs.obstacles = {plane_obstacle({0, 0, 0}, {0, 0, 1}),
                            contact::cloth_obstacle(ball, pose, pose, kDt)};
  for (int n = 0; n < 120; n++) step(exec, drape.model, drape.state, drape.inputs, kDt);
  ClothDrapeRow row{.vertices = kSide * kSide};
  row.contacts_per_vertex = double(drape.state.contacts.list.size()) / row.vertices;
  row.one = frame_ms(Exec(1), drape);
  row.all = frame_ms(exec, drape);
  row.smallest_distance =
      self_distance(exec, drape.model, drape.state).smallest / drape.model.params.collision.thickness;
  return row;
}

ClothSolverRow measure_solver(const Exec& exec, const BenchSheet& flag, Method method, const char* name) {
  constexpr double kGoal = 0.1;
  ClothSolverRow row{.method = name};
  const auto solve = [&](State& state, int sweeps) {
    start_change(exec, flag.model, state, kDt);
    method == Method::kConjugateGradients
        ? solve_by_conjugate_gradients(exec, flag.model, state, {.iterations = sweeps})
        : solve_by_sweeps(exec, flag.model, state, method, sweeps);
  };
  for (int sweeps = 4; sweeps <= 8192; sweeps += std::max(1, sweeps / 4)) {
    State state = flag.state;
    solve(state, sweeps);
    row.residual = residual(exec, flag.model, state);
    if (row.residual > kGoal) continue;
    row.sweeps = sweeps;
    row.ms = median_ms(5, [&] { solve(state, sweeps); });
    break;
  }
  return row;
}

}  // namespace

ClothBench bench_cloth(const Exec& exec, int largest, const Progress& progress) {
  ClothBench bench{.threads = exec.threads(), .copy_bandwidth = copy_bandwidth(exec)};
  const Result<Gpu> gpu = open_gpu();
  bench.gpu = gpu ? gpu->name : gpu.error().message;
  const int sides[] = {50, 100, 316, 1000};
  for (const int side : sides)
    if (side * side <= largest) {
      bench.frames.push_back(measure_frames(exec, bench.copy_bandwidth, side));
      if (progress) progress(0.2 * double(bench.frames.size()));
    }
  bench.drape = measure_drape(exec);
  BenchSheet taut = flag(exec, 100, false);
  for (int n = 0; n < kWarmFrames; n++) step(exec, taut.model, taut.state, taut.inputs, kDt);
  taut.inputs.measure_residual = true;
  assemble(exec, taut.model, taut.state, taut.inputs, kDt);
  bench.solvers = {measure_solver(exec, taut, Method::kJacobi, "Jacobi"),
                   measure_solver(exec, taut, Method::kChebyshev, "Chebyshev"),
                   measure_solver(exec, taut, Method::kConjugateGradients, "conjugate gradients")};
  return bench;
}

}  // namespace turgor
