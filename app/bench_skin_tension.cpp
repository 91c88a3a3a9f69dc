#include "app/bench_skin_tension.hpp"

#include <algorithm>

#include "app/machine.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor {

namespace {

using lattice::BodyNodes, lattice::Method, lattice::Model, lattice::Params, lattice::State;

constexpr double kDt = 1.0 / 60;
constexpr int kFrames = 11;
// Least cost of a sweep per slot of a run: bytes of memory traffic, and operations. A root or a quotient
// counts as one operation.
constexpr double kPbdBytes = 32;            // read u, w, root; write u
constexpr double kPbdFlops = 7 * 32;        // edges
constexpr double kVbdBytes = 56;            // read u, u_before, v, w, root; write u
constexpr double kVbdFlops = 14 * 47 + 75;  // springs, and the 3×3 system of the node

struct DataSet {
  const char* name;
  PhantomKind kind;
  int slices;
  SkinTensionTimes paper;
};
constexpr DataSet kDataSets[] = {
    {"A abdomen", PhantomKind::kTorso, 300, {1447, 1493, 74.06, 79.73}},
    {"B head", PhantomKind::kHead, 544, {2753, 2773, 126.52, 131.89}},
    {"C leg", PhantomKind::kLeg, 1152, {5384, 5438, 257.75, 266.08}},
};

CtVolume shrunken_phantom(const Exec& exec, PhantomKind kind, int shrink) {
  PhantomParams params = default_phantom(kind);
  params.size = {params.size.x / shrink, params.size.y / shrink, params.size.z / shrink};
  params.spacing *= double(shrink);
  return make_phantom(exec, params);
}

Params solver_params(Method method, bool skin) {
  Params params;
  params.solver.method = method;
  params.skin.enabled = skin;
  params.skin.law = method == Method::kPbd ? lattice::SkinLaw::kArea : lattice::SkinLaw::kFiber;
  return params;
}

double frame_ms(const Exec& exec, const Model& model) {
  State state = make_state(model);
  return median_ms(kFrames, [&] { lattice::step(exec, model, state, {}, kDt); });
}

/// Times two models in alternation, so that a change of the clock frequency affects both.
void frames_by_turns(const Exec& exec, const Model& a, const Model& b, double& ms_a, double& ms_b) {
  State state_a = make_state(a), state_b = make_state(b);
  std::vector<double> times_a, times_b;
  for (int n = 0; n < kFrames; n++) {
    times_a.push_back(median_ms(1, [&] { lattice::step(exec, a, state_a, {}, kDt); }));
    times_b.push_back(median_ms(1, [&] { lattice::step(exec, b, state_b, {}, kDt); }));
  }
  ms_a = median(times_a), ms_b = median(times_b);
}

double gpu_frame_ms(const Gpu& gpu, const Model& model, lattice::Frames frames) {
  const auto body = lattice::upload_model(gpu, model, frames);
  if (!body) return 0;
  lattice::DeviceState state = make_state(model);
  state.use_backend(*body);
  const auto step = [&] { state.step(Exec(), model, {}, kDt); };
  step();
  return median_ms(kFrames, step);
}

OrderingTimes measure_orderings(const Exec& exec, const BodyNodes& nodes, Params params) {
  OrderingTimes times;
  const Model slabs = lattice::assemble(exec, nodes, nullptr, params).value();
  params.solver.ordering = lattice::Ordering::kColors;
  const Model colors = lattice::assemble(exec, nodes, nullptr, params).value();
  frames_by_turns(exec, slabs, colors, times.slabs, times.colors);
  if (const Result<Gpu> gpu = open_gpu()) {
    times.gpu = gpu_frame_ms(*gpu, colors, lattice::Frames::kAsGraphs);
    times.gpu_one_by_one = gpu_frame_ms(*gpu, colors, lattice::Frames::kOneByOne);
  }
  return times;
}

SkinTensionTimes measure_pbd(const Exec& exec, const BodyNodes& nodes, const Model& without,
                             const Model& with) {
  SkinTensionTimes times;
  const auto grouping = [&](bool skin) {
    return median_ms(
        3, [&] { (void)lattice::assemble(exec, nodes, nullptr, solver_params(Method::kPbd, skin)); });
  };
  times.grouping_without = grouping(false);
  times.grouping_with = grouping(true);
  frames_by_turns(exec, without, with, times.frame_without, times.frame_with);
  return times;
}

/// Residual after one frame of 5 sweeps when gravity is switched on [N]. The energy of `judge` measures both
/// solvers.
double residual_after_frame(const Exec& exec, const Model& solver, const Model& judge) {
  State state = make_state(judge);
  const lattice::Inputs inputs{.gravity = {0, 9.81, 0}};
  lattice::predict(exec, judge, state, inputs, kDt);
  for (int sweep = 0; sweep < judge.params.solver.sweeps; sweep++)
    if (solver.params.solver.method == Method::kPbd)
      lattice::sweep_pbd(exec, solver, state);
    else
      lattice::sweep_vbd(exec, solver, state, inputs, kDt);
  return lattice::measure_residual(exec, judge, state, inputs, kDt).rms;
}

/// Fractions of the two limits of the machine that a sweep over `slots` reaches.
void set_fractions(const SkinTensionBench& limits, double slots, double ms, double bytes, double flops,
                   double& of_bandwidth, double& of_arithmetic) {
  of_bandwidth = slots * bytes / (ms * 1e-3) / limits.copy_bandwidth;
  of_arithmetic = slots * flops / (ms * 1e-3) / limits.arithmetic_rate;
}

SkinTensionRow measure(const Exec& exec, const SkinTensionBench& limits, const DataSet& data, int shrink,
                       const Progress& progress) {
  SkinTensionRow row{.name = data.name, .paper = data.paper};
  const Exec one(1);

  const CtVolume ct = shrunken_phantom(exec, data.kind, shrink);
  row.voxels = ct.grid.size;
  progress(0.4);
  const Params pbd = solver_params(Method::kPbd, true), vbd = solver_params(Method::kVbd, true);
  row.body_seconds = 1e-3 * median_ms(3, [&] { (void)lattice::build(exec, ct, {}, pbd); });
  const BodyNodes nodes = lattice::classify(exec, ct, nullptr, pbd).value();
  row.nodes = nodes.grid.size;
  {
    const Model without = lattice::assemble(exec, nodes, nullptr, solver_params(Method::kPbd, false)).value();
    const Model with = lattice::assemble(exec, nodes, nullptr, pbd).value();
    row.skin_triangles = with.anatomy.skin.triangles.size();
    row.bytes_per_node =
        double(lattice::memory_bytes(with, make_state(with))) / node_count(with.anatomy.lattice);
    row.one_thread = measure_pbd(one, nodes, without, with);
    row.all_threads = measure_pbd(exec, nodes, without, with);
    State state = make_state(without);
    const double sweep_ms = median_ms(kFrames, [&] { lattice::sweep_pbd(exec, without, state); });
    set_fractions(limits, double(slots_in(without.pbd.constraint_runs)), sweep_ms, kPbdBytes, kPbdFlops,
                  row.bandwidth_fraction, row.arithmetic_fraction);
  }
  row.pbd_frames = measure_orderings(exec, nodes, pbd);
  row.vbd_frames = measure_orderings(exec, nodes, vbd);
  progress(0.7);
  const Model model = lattice::assemble(exec, nodes, nullptr, vbd).value();
  row.vbd_frame_one = frame_ms(one, model);
  row.vbd_frame = frame_ms(exec, model);
  {
    const Model without = lattice::assemble(exec, nodes, nullptr, solver_params(Method::kVbd, false)).value();
    State state = make_state(without);
    const double sweep_ms = median_ms(kFrames, [&] { lattice::sweep_vbd(exec, without, state, {}, kDt); });
    set_fractions(limits, double(slots_in(without.anatomy.free_runs)), sweep_ms, kVbdBytes, kVbdFlops,
                  row.vbd_bandwidth_fraction, row.vbd_arithmetic_fraction);
  }
  Params area = pbd;
  area.solver.method = Method::kVbd;  // the paper's constraints, with stiffness in physical units
  const Model judge = lattice::assemble(exec, nodes, nullptr, area).value();
  row.residual_pbd = residual_after_frame(exec, lattice::assemble(exec, nodes, nullptr, pbd).value(), judge);
  row.residual_vbd = residual_after_frame(exec, judge, judge);
  progress(0.8);
  State state = make_state(model);
  for (int n = 0; n < 3; n++) lattice::step(exec, model, state, {}, kDt);
  const Grid half = lattice::resized(ct.grid, {row.voxels.x / 2, row.voxels.y / 2, row.voxels.z / 2});
  row.resample_half = median_ms(3, [&] { (void)lattice::resample_ct(exec, model, state, ct, half); });
  row.resample_full = median_ms(3, [&] { (void)lattice::resample_ct(exec, model, state, ct, ct.grid); });
  return row;
}

double bar_ms(const Exec& exec, int& tets) {
  BodyNodes nodes;
  nodes.grid = {.size = {36, 17, 16}, .spacing = {0.01, 0.01, 0.01}};
  const std::size_t count = sample_count(nodes.grid);
  nodes.hu.assign(count, 0);
  nodes.tissue.assign(count, lattice::Tissue::kMuscle);
  nodes.young.assign(count, 5e3f);
  nodes.fixed.assign(count, 0);
  std::fill_n(nodes.fixed.begin(), 36 * 17, std::uint8_t(1));
  Params params = solver_params(Method::kPbd, false);
  params.solver.pbd_volume = true;
  const Model model = lattice::assemble(exec, nodes, nullptr, params).value();
  tets = 6 * 35 * 16 * 15;
  State state = make_state(model);
  return median_ms(201, [&] { lattice::step(exec, model, state, {.gravity = {0, 0, -9.81}}, kDt); });
}

}  // namespace

SkinTensionBench bench_skin_tension(const Exec& exec, int shrink, const std::optional<std::string>& only,
                                    const Progress& progress) {
  SkinTensionBench bench{.threads = exec.threads(),
                         .copy_bandwidth = copy_bandwidth(exec),
                         .arithmetic_rate = arithmetic_rate(exec)};
  const Result<Gpu> gpu = open_gpu();
  bench.gpu = gpu ? gpu->name : gpu.error().message;
  bench.bar_frame_one = bar_ms(Exec(1), bench.bar_tets);
  bench.bar_frame = bar_ms(exec, bench.bar_tets);
  double done = 0, all = 0;
  const auto wanted = [&](const DataSet& data) { return !only || data.name[0] == only->front(); };
  for (const DataSet& data : kDataSets)
    if (wanted(data)) all += data.slices;
  for (const DataSet& data : kDataSets) {
    if (!wanted(data)) continue;
    const auto data_progress = [&](double fraction) { progress((done + fraction * data.slices) / all); };
    bench.rows.push_back(measure(exec, bench, data, shrink, data_progress));
    done += data.slices;
  }
  bench.growth = bench_growth(exec);
  return bench;
}

}  // namespace turgor
