#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/model/fields.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Calls body(run) on the slots of a layer that can move and do not stand still.
template <class Body>
void for_each_run(const Model& model, const State& state, int k, const Body& body) {
  const bool all = !can_sleep(model) || state.sleep.carried || state.sleep.awake.empty();
  for (int j = 0; j < model.lattice.size.y; j++) {
    const int row = row_of(model, row_slot(model.lattice, j, k));
    if (!all && !state.sleep.awake[std::size_t(row)]) continue;
    for (const int half_row : {2 * row, 2 * row + 1})
      for (const Run run : model.moving.of_half_row(half_row)) body(run);
  }
}

/// Do velocities lead neighbours too far?
bool is_wild(const Exec& exec, const Model& model, State& state, Real dt, const HaloExchange* halo) {
  const Real most = wild_from(model, dt);
  if (!(2 * state.fastest > most)) return false;
  const FindWild find{moving_nodes(model, state), {neighbors_of(model, 0), neighbors_of(model, 1)}, most};
  std::atomic<bool> found = false;
  for_layers(exec, model.owned, [&](std::size_t k) {
    for_each_run(model, state, int(k), [&](Run run) {
      for (int s = run.begin; s < run.begin + run.count && !found; s++)
        if (find.is_wild(s)) found = true;
    });
  });
  return halo ? halo->largest(found.load()) != 0 : found.load();
}

struct PredictLayer {
  const Model& model;
  State& state;
  Vec3 gravity;
  Real dt;
  bool goes_on;  // as fast as it was

  void operator()(std::size_t k) const {
    const Real way = goes_on ? dt : 0;
    const auto advance = [&](Run run, Real* __restrict u, Real* __restrict before, const Real* __restrict v,
                             Real g) {
      const Real* w = model.inverse_mass.data();
      const std::uint8_t* removed = state.removed.data();
      for (int s = run.begin; s < run.begin + run.count; s++) {
        before[s] = u[s];
        u[s] += w[s] > 0 && !removed[s] ? way * v[s] + g : 0;
      }
    };
    for_each_run(model, state, int(k), [&](Run run) {
      advance(run, state.u.x.data(), state.u_before.x.data(), state.v.x.data(), dt * dt * gravity.x);
      advance(run, state.u.y.data(), state.u_before.y.data(), state.v.y.data(), dt * dt * gravity.y);
      advance(run, state.u.z.data(), state.u_before.z.data(), state.v.z.data(), dt * dt * gravity.z);
    });
  }
};

/// Inertia leads to u + h (v + h w f): with its loads in its velocity, no sweep need know of them.
void add_loads(const Model& model, State& state, std::span<const NodeLoad> loads, Real dt) {
  for (const NodeLoad& load : loads) {
    TURGOR_ASSERT(load.slot >= 0 && std::size_t(load.slot) < model.inverse_mass.size(),
                  "a load is on a slot of the lattice");
    const auto slot = std::size_t(load.slot);
    if (!state.removed[slot]) state.v.set(slot, state.v[slot] + load.force * (dt * model.inverse_mass[slot]));
  }
}

/// v = (u − u_before)/h, damped, and the largest |v|²: the largest of bit patterns, since those of positive
/// numbers are in order and those of not-a-number come last.
struct FinishLayer {
  const Model& model;
  State& state;
  Real scale;
  std::atomic<std::uint32_t>& largest;

  std::uint32_t largest_of(Run run) const {
    std::uint32_t found = 0;
    const Real *vx = state.v.x.data(), *vy = state.v.y.data(), *vz = state.v.z.data();
    for (int s = run.begin; s < run.begin + run.count; s++) {
      const Real speed2 = vx[s] * vx[s] + vy[s] * vy[s] + vz[s] * vz[s];
      const std::uint32_t bits = std::bit_cast<std::uint32_t>(speed2) & 0x7fffffffu;
      found = bits > found ? bits : found;
    }
    return found;
  }

  void operator()(std::size_t k) const {
    const auto velocity = [&](Run run, Real* __restrict v, const Real* __restrict u,
                              const Real* __restrict before) {
      for (int s = run.begin; s < run.begin + run.count; s++) v[s] = (u[s] - before[s]) * scale;
    };
    std::uint32_t found = 0;
    for_each_run(model, state, int(k), [&](Run run) {
      velocity(run, state.v.x.data(), state.u.x.data(), state.u_before.x.data());
      velocity(run, state.v.y.data(), state.u.y.data(), state.u_before.y.data());
      velocity(run, state.v.z.data(), state.u.z.data(), state.u_before.z.data());
      found = std::max(found, largest_of(run));
    });
    std::uint32_t seen = largest.load();
    while (seen < found && !largest.compare_exchange_weak(seen, found)) {
    }
  }
};

/// To the last good state, at rest; in place, so that nobody's view of u moves. Projections leave what is not
/// finite in nodes that are held and in slots without a node, too.
void go_back(const Model& model, State& state) {
  for (std::size_t s = 0; s < model.inverse_mass.size(); s++) {
    const Vec3 u = state.u[s];
    if (model.inverse_mass[s] > 0 || !std::isfinite(u.x + u.y + u.z)) state.u.set(s, state.u_before[s]);
    state.v.set(s, {});
  }
  state.virtual_nodes = state.virtual_nodes_before;
  state.fastest = 0;
  state.sleep.still.clear();  // everybody is awake
}

void check_contacts(const Model& model, std::span<const NodeContact> contacts) {
  TURGOR_ASSERT(contacts.empty() || model.params.solver.method == Method::kVbd,
                "contacts press with newtons, which projections do not know");
  for (std::size_t c = 0; c < contacts.size(); c++) {
    const auto slot = std::size_t(contacts[c].slot);
    TURGOR_ASSERT(c == 0 || contacts[c - 1].slot <= contacts[c].slot, "the slots of contacts ascend");
    TURGOR_ASSERT(slot < model.inverse_mass.size() && model.inverse_mass[slot] > 0,
                  "contacts are on nodes that move");
  }
}

}  // namespace

Vec3 lattice_gravity(const Model& model, const Inputs& inputs) {
  return Vec3(inverse(model.grid.axes) * inputs.gravity);
}

void predict(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  // Projections know forces by where they begin. Descent has them in its energy and begins without: weight
  // that few sweeps cannot carry back to the nodes that are held, or a large load on a light node, would turn
  // cells inside out, from where springs do not lead back. A body that nothing holds falls as a whole.
  const bool pbd = model.params.solver.method == Method::kPbd, held = model.free_nodes < model.body_nodes;
  state.virtual_nodes_before = state.virtual_nodes;
  if (pbd) add_loads(model, state, inputs.loads, Real(dt));
  const Vec3 fall = pbd || !held ? lattice_gravity(model, inputs) : Vec3{};
  const bool goes_on = pbd || !held || !is_wild(exec, model, state, Real(dt), inputs.halo);
  for_layers(exec, moved_layers(model), PredictLayer{model, state, fall, Real(dt), goes_on});
  if (!pbd) add_loads(model, state, inputs.loads, Real(dt));
}

StepReport finish(const Exec& exec, const Model& model, State& state, double dt, const HaloExchange* halo) {
  std::atomic<std::uint32_t> largest{0};
  const Real scale = speed_scale(model.params.solver, dt);
  for_layers(exec, moved_layers(model), FinishLayer{model, state, scale, largest});
  const Real speed2 = std::bit_cast<Real>(halo ? halo->largest(largest.load()) : largest.load());
  if (std::isfinite(speed2)) {
    state.time += dt;
    state.fastest = std::sqrt(speed2);
    return {.finite = true, .largest_speed = state.fastest};
  }
  go_back(model, state);
  return {.finite = false};
}

StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  check_contacts(model, inputs.contacts);
  const bool coarse = prepare_coarse_space(model, state, inputs, dt), may_sleep = can_sleep(model);
  if (may_sleep) wake_rows(model, state, inputs, coarse);
  const bool solves = coarse && (!may_sleep || state.sleep.carried);
  predict(exec, model, state, inputs, dt);
  const bool measures = inputs.measure_residual && model.params.solver.method == Method::kVbd;
  Residual residual;
  const double before = measures ? measure_residual(exec, model, state, inputs, dt).rms : 0;
  const int sweeps = model.params.solver.sweeps;
  bool is_slow = false;  // nothing is carried further than a sleeper goes: no need to look twice
  const bool solid = model.params.tissue.law == TissueLaw::kSolid;
  for (int sweep = 0; sweep < sweeps; sweep++) {
    if (model.params.solver.method == Method::kPbd) {
      sweep_pbd(exec, model, state, inputs.halo);
      continue;
    }
    if (solves && is_turn(solid, sweep, sweeps))
      is_slow = apply_coarse_correction(exec, model, state, inputs, dt) <= model.params.solver.sleep * dt;
    sweep_vbd(exec, model, state, inputs, dt, sweep_order(solid, sweep, sweeps));
  }
  if (solves && !(may_sleep && is_slow)) apply_coarse_correction(exec, model, state, inputs, dt);
  if (measures) residual = measure_residual(exec, model, state, inputs, dt);
  residual.before = before;
  StepReport report = finish(exec, model, state, dt, inputs.halo);
  report.residual = residual;
  if (may_sleep && report.finite) {
    lay_down_rows(exec, model, state, dt, coarse);
    count_sleepers(model, state, report);
  }
  return report;
}

std::size_t memory_bytes(const Model& model, const State& state) {
  return bytes_of_fields(model, state) + (state.coarse ? memory_bytes(*state.coarse) : 0);
}

std::uint64_t hash_of_layers(const Model& model, const State& state, std::uint64_t hash) {
  const Lattice& l = model.lattice;
  for (int k = model.owned.begin; k < model.owned.end; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++)
        hash = hash_of_fields(state, std::size_t(row_slot(l, j, k) + parity * l.half),
                              std::size_t(half_count(l, parity)), hash);
  return hash;
}

std::uint64_t state_hash(const Model& model, const State& state) {
  std::uint64_t hash = hash_of_layers(model, state, kHashSeed);
  if (!state.virtual_nodes.empty())
    hash = hash_values(std::span<const VirtualNodeShift>(state.virtual_nodes), hash);
  if (can_sleep(model)) {
    hash = hash_values(std::span<const std::uint8_t>(state.sleep.still), hash);
    hash = hash_values(std::span<const std::uint8_t>(&state.sleep.coarse_still, 1), hash);
  }
  return hash;
}

}  // namespace turgor::lattice
