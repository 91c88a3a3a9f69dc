// First and last phase of a step: the predictor, and velocities from displacements.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Calls body(run) for the free nodes of a layer, without rows that sleep.
template <class Body>
void for_each_run(const Model& model, const State& state, int k, const Body& body) {
  const bool all = !can_sleep(model) || state.sleep.moved_by_coarse || state.sleep.awake.empty();
  for (int j = 0; j < model.lattice.size.y; j++) {
    const int row = row_of(model, row_slot(model.lattice, j, k));
    if (!all && !state.sleep.awake[std::size_t(row)]) continue;
    for (const int half_row : {2 * row, 2 * row + 1})
      for (const Run run : model.free_runs.of_half_row(half_row)) body(run);
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
  for_layers(exec, model.owned, [&](std::size_t k) {
    for_each_run(model, state, int(k), [&](Run run) {
      for (int s = run.begin; s < run.begin + run.count && !found; s++)
        if (find.diverges(s)) found = true;
    });
  });
  return halo ? halo->largest(found.load()) != 0 : found.load();
}

struct PredictLayer {
  const Model& model;
  State& state;
  Vec3 gravity;
  Real dt;
  bool keeps_velocity;  // false: starts from rest, because velocities diverge

  void operator()(std::size_t k) const {
    const Real velocity_step = keeps_velocity ? dt : 0;
    // displacement along one axis
    const auto advance = [&](Run run, Real* __restrict u, Real* __restrict before, const Real* __restrict v,
                             Real g) {
      const Real* w = model.inverse_mass.data();
      const std::uint8_t* removed = state.cuts.removed.data();
      for (int s = run.begin; s < run.begin + run.count; s++) {
        before[s] = u[s];
        u[s] += w[s] > 0 && !removed[s] ? velocity_step * v[s] + g : 0;
      }
    };
    for_each_run(model, state, int(k), [&](Run run) {
      advance(run, state.motion.u.x.data(), state.motion.u_before.x.data(), state.motion.v.x.data(),
              dt * dt * gravity.x);
      advance(run, state.motion.u.y.data(), state.motion.u_before.y.data(), state.motion.v.y.data(),
              dt * dt * gravity.y);
      advance(run, state.motion.u.z.data(), state.motion.u_before.z.data(), state.motion.v.z.data(),
              dt * dt * gravity.z);
    });
  }
};

/// Adds loads to velocities: y = u + h (v + h w f). The sweeps need no further treatment of loads.
void add_loads(const Model& model, State& state, std::span<const NodeLoad> loads, Real dt) {
  for (const NodeLoad& load : loads) {
    TURGOR_ASSERT(load.slot >= 0 && std::size_t(load.slot) < model.inverse_mass.size(),
                  "loads act on slots of the lattice");
    const auto slot = std::size_t(load.slot);
    if (!state.cuts.removed[slot])
      state.motion.v.set(slot, state.motion.v[slot] + load.force * (dt * model.inverse_mass[slot]));
  }
}

/// v = (u − u_before)/h with damping, and the largest |v|². The maximum is taken of bit patterns: those of
/// positive numbers are ordered, and NaN is the largest.
struct FinishLayer {
  const Model& model;
  State& state;
  Real scale;
  std::atomic<std::uint32_t>& largest;

  std::uint32_t largest_of(Run run) const {
    std::uint32_t found = 0;
    const Real *vx = state.motion.v.x.data(), *vy = state.motion.v.y.data(), *vz = state.motion.v.z.data();
    for (int s = run.begin; s < run.begin + run.count; s++) {
      const Real speed2 = vx[s] * vx[s] + vy[s] * vy[s] + vz[s] * vz[s];
      const std::uint32_t bits = std::bit_cast<std::uint32_t>(speed2) & 0x7fffffffu;
      found = bits > found ? bits : found;
    }
    return found;
  }

  void operator()(std::size_t k) const {
    // velocity along one axis
    const auto velocity = [&](Run run, Real* __restrict v, const Real* __restrict u,
                              const Real* __restrict before) {
      for (int s = run.begin; s < run.begin + run.count; s++) v[s] = (u[s] - before[s]) * scale;
    };
    std::uint32_t found = 0;
    for_each_run(model, state, int(k), [&](Run run) {
      velocity(run, state.motion.v.x.data(), state.motion.u.x.data(), state.motion.u_before.x.data());
      velocity(run, state.motion.v.y.data(), state.motion.u.y.data(), state.motion.u_before.y.data());
      velocity(run, state.motion.v.z.data(), state.motion.u.z.data(), state.motion.u_before.z.data());
      found = std::max(found, largest_of(run));
    });
    // maximum over layers
    std::uint32_t seen = largest.load();
    while (seen < found && !largest.compare_exchange_weak(seen, found)) {
    }
  }
};

/// Restores the last finite state, at rest. u is changed in place, so that views of it stay valid.
/// Projections may also leave non-finite values in fixed nodes and in empty slots.
void restore_last_state(const Model& model, State& state) {
  for (std::size_t s = 0; s < model.inverse_mass.size(); s++) {
    const Vec3 u = state.motion.u[s];
    if (model.inverse_mass[s] > 0 || !std::isfinite(u.x + u.y + u.z))
      state.motion.u.set(s, state.motion.u_before[s]);
    state.motion.v.set(s, {});
  }
  state.motion.virtual_u = state.motion.virtual_u_before;
  state.motion.fastest = 0;
  state.sleep.still_steps.clear();  // all rows are awake
}

}  // namespace

Vec3 lattice_gravity(const Model& model, const Inputs& inputs) {
  return Vec3(inverse(model.grid.axes) * inputs.gravity);
}

void predict(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  // PBD only takes forces through the predictor, so it starts with gravity and loads. VBD has them in its
  // energy and starts without. Otherwise weight that few sweeps cannot carry to the fixed nodes, or a large
  // load on a light node, would invert cells, and springs do not recover from that. A free body falls as a
  // whole.
  const bool pbd = model.params.solver.method == Method::kPbd, held = model.free_nodes < model.body_nodes;
  // state before the step
  state.motion.virtual_u_before = state.motion.virtual_u;
  // starting point of the sweeps
  if (pbd) add_loads(model, state, inputs.loads, Real(dt));
  const Vec3 fall = pbd || !held ? lattice_gravity(model, inputs) : Vec3{};
  const bool keeps_velocity = pbd || !held || !velocities_diverge(exec, model, state, Real(dt), inputs.halo);
  for_layers(exec, moved_layers(model), PredictLayer{model, state, fall, Real(dt), keeps_velocity});
  if (!pbd) add_loads(model, state, inputs.loads, Real(dt));
}

StepReport finish(const Exec& exec, const Model& model, State& state, double dt, const HaloExchange* halo) {
  std::atomic<std::uint32_t> largest{0};
  const Real scale = speed_scale(model.params.solver, dt);
  for_layers(exec, moved_layers(model), FinishLayer{model, state, scale, largest});
  const Real speed2 = std::bit_cast<Real>(halo ? halo->largest(largest.load()) : largest.load());
  if (std::isfinite(speed2)) {
    state.motion.time += dt;
    state.motion.fastest = std::sqrt(speed2);
    return {.finite = true, .largest_speed = state.motion.fastest};
  }
  restore_last_state(model, state);
  return {.finite = false};
}

}  // namespace turgor::lattice
