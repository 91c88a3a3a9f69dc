// First and last phase of a step: the predictor, and velocities from displacements.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Calls body(run) for the free nodes of a layer, without rows that sleep.
template <class Body>
void for_each_run(const Model& model, const State& state, int k, const Body& body) {
  const bool all = !can_sleep(model) || state.sleep.moved_by_coarse || state.sleep.awake.empty();
  for (int j = 0; j < model.anatomy.lattice.size.y; j++) {
    const int row = row_of(model, row_slot(model.anatomy.lattice, j, k));
    if (!all && !state.sleep.awake[std::size_t(row)]) continue;
    for (const int half_row : {2 * row, 2 * row + 1})
      for (const Run run : model.anatomy.free_runs.of_half_row(half_row)) body(run);
  }
}

/// True if the velocities move neighbors farther apart or together than kLargestRelativeMotion.
bool velocities_diverge(const Exec& exec, const Model& model, State& state, Real dt,
                        const HaloExchange* halo) {
  const Real most = largest_relative_speed(model, dt);
  if (!(2 * state.motion.fastest > most)) return false;
  const FindDivergingNeighbors find{
      host_free_nodes(model, state), {neighbors_of(model, 0), neighbors_of(model, 1)}, most};
  std::atomic<bool> found = false;
  for_layers(exec, model.anatomy.owned, [&](std::size_t k) {
    for_each_run(model, state, int(k), [&](Run run) {
      for (int s = run.begin; s < run.begin + run.count && !found; s++)
        if (find.diverges(s)) found = true;
    });
  });
  return halo ? halo->largest(found.load()) != 0 : found.load();
}

/// True if threads or the walls of a sewn wound couple points. They are stiffer than the tissue: few sweeps
/// would not take back their strain at a start u + h v, and would leave its energy to the body.
bool is_sewn(const PointSprings* springs) {
  return springs != nullptr && std::any_of(springs->all.begin(), springs->all.end(),
                                           [](const PointSpring& s) { return s.coupling.count > 0; });
}

/// Predictor for the nodes of a layer.
struct PredictLayer {
  const Model& model;
  const State& state;
  PredictNode node;
  Real velocity_step;  // h, or 0 for a start from rest [s]

  void operator()(std::size_t k) const {
    for_each_run(model, state, int(k), [&](Run run) {
      const PredictNode local = node;  // local copy, so that stores cannot alias it
      const Real step = velocity_step;
      TURGOR_LANES
      for (int s = run.begin; s < run.begin + run.count; s++) local.predict(s, step);
    });
  }
};

/// Velocities of the nodes of a layer, and the largest |v|². Bit patterns of positive numbers are ordered,
/// and NaN is the largest.
struct FinishLayer {
  const Model& model;
  const State& state;
  FinishNode node;
  std::uint32_t& largest;

  void operator()(std::size_t k) const {
    std::uint32_t found = 0;
    for_each_run(model, state, int(k), [&](Run run) {
      const FinishNode local = node;  // local copy, so that stores cannot alias it
      TURGOR_LANES
      for (int s = run.begin; s < run.begin + run.count; s++) {
        const std::uint32_t bits = local.finish(s);
        found = bits > found ? bits : found;
      }
    });
    atomic_max(largest, found);
  }
};

/// Restores the last finite state, at rest.
void restore_last_state(const Model& model, State& state) {
  const RestoreSlot restore{host_free_nodes(model, state)};
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++) restore(s);
  state.motion.virtual_u = state.motion.virtual_u_before;
  state.motion.fastest = 0;
  state.sleep.still_steps.clear();  // all rows are awake
}

}  // namespace

Vec3 lattice_gravity(const Model& model, const Inputs& inputs) {
  return Vec3(inverse(model.anatomy.grid.axes) * inputs.gravity);
}

void add_loads(const Model& model, State& state, const Inputs& inputs, double dt) {
  const AddLoad by{host_free_nodes(model, state), nullptr, 0, Real(dt)};
  for (const NodeLoad& load : inputs.loads) {
    TURGOR_ASSERT(load.slot >= 0 && std::size_t(load.slot) < model.anatomy.inverse_mass.size(),
                  "loads act on slots of the lattice");
    if (!state.cuts.removed[std::size_t(load.slot)]) by.add(load);
  }
}

void move_to_start(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                   double time_step) {
  // PBD and free bodies start with gravity; bodies whose velocities diverge, or that stitches hold, start
  // from rest
  const bool pbd = model.params.solver.method == Method::kPbd,
             held = model.anatomy.free_nodes < model.anatomy.body_nodes;
  const Real dt = Real(time_step);
  Vec3 g;
  if (pbd || !held) g = lattice_gravity(model, inputs);
  if (!pbd && !held) g += Vec3(inputs.start_acceleration);
  const bool keeps_velocity =
      pbd || !held || !(is_sewn(inputs.springs) || velocities_diverge(exec, model, state, dt, inputs.halo));
  // state before the step, and starting point of the sweeps
  state.motion.virtual_u_before = state.motion.virtual_u;
  const PredictNode node{host_free_nodes(model, state), {dt * dt * g.x, dt * dt * g.y, dt * dt * g.z}, dt};
  for_layers(exec, moved_layers(model), PredictLayer{model, state, node, keeps_velocity ? dt : 0});
}

void predict(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  const bool pbd = model.params.solver.method == Method::kPbd;
  if (pbd) add_loads(model, state, inputs, dt);
  move_to_start(exec, model, state, inputs, dt);
  if (!pbd) add_loads(model, state, inputs, dt);
}

StepReport finish(const Exec& exec, const Model& model, State& state, double dt, const HaloExchange* halo) {
  std::uint32_t largest = 0;
  const FinishNode node{host_free_nodes(model, state), speed_scale(model.params.solver, dt)};
  for_layers(exec, moved_layers(model), FinishLayer{model, state, node, largest});
  const Real speed2 = std::bit_cast<Real>(halo ? halo->largest(largest) : largest);
  if (std::isfinite(speed2)) {
    state.motion.time += dt;
    state.motion.fastest = std::sqrt(speed2);
    return {.finite = true, .largest_speed = state.motion.fastest};
  }
  restore_last_state(model, state);
  return {.finite = false};
}

}  // namespace turgor::lattice
