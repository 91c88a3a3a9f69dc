#include "turgor/models/cloth/solver/system.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/forces/vertex_springs.hpp"
#include "turgor/models/cloth/forces/wind.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/solver/implicit_contact.hpp"
#include "turgor/models/cloth/solver/motion_kernels.hpp"
#include "turgor/models/cloth/solver/system_kernels.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 16;  // batches

/// Adds the contact impulses of the step before (warm start), so that a sheet at rest need not find them
/// again.
void add_impulses(const Contacts& contacts, const aligned_vector<Real>& free_mass, Vectors& force) {
  for (const Contact& c : contacts.list) {
    if (!(c.impulse > 0)) continue;
    const Real factor = c.is_implicit ? 1 : c.warm_start;  // implicit ones have it already
    for (std::size_t k = 0; k < 4; k++) {
      if (c.vertex[k] < 0) continue;
      const auto v = std::size_t(c.vertex[k]);
      if (free_mass[v] > 0)
        force.add(v, (c.normal * c.impulse + c.friction_impulse) * (factor * c.weight[k]));
    }
  }
}

/// Velocity change of held vertices, which reaches their goals.
void aim_holds(const Model& model, State& state, Real dt) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  for_holds(state, AimHolds{view(model, state), state.holds.data(), dt});
}

/// Sum over the vertices of a component, in chunks that do not depend on the number of threads.
template <class Term>
auto component_sum(const Exec& exec, int begin, int end, const Term& term) {
  constexpr int kChunkSize = 4096;
  std::vector<decltype(term(0))> chunks(std::size_t((end - begin + kChunkSize - 1) / kChunkSize));
  parallel_for(exec, chunks.size(), [&](std::size_t p) {
    const int from = begin + int(p) * kChunkSize;
    for (int v = from; v < std::min(from + kChunkSize, end); v++) chunks[p] += term(std::size_t(v));
  });
  decltype(term(0)) sum{};
  for (const auto chunk : chunks) sum += chunk;
  return sum;
}

struct IsComponentHeld {
  const std::vector<Hold>& holds;

  bool operator()(int begin, int end) const {
    const auto first = std::lower_bound(holds.begin(), holds.end(), begin,
                                        [](const Hold& h, int v) { return h.vertex < v; });
    return first != holds.end() && first->vertex < end;
  }
};

}  // namespace

void assemble(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  // wind load and springs, and their drag on free components
  System& system = state.system;
  const Damping& damping = model.params.damping;
  system.mass_factor = Real(1 + dt * damping.motion),
  system.stiffness_factor = Real(dt * dt + dt * damping.stretch);
  const bool has_wind = inputs.air.density > 0,
             has_springs = !inputs.springs.empty() || !inputs.loads.empty(),
             has_air = has_wind || has_springs;
  const bool uses_cg = uses_conjugate_gradients(model.params.solver.method);
  const bool keeps_air = inputs.measure_residual || uses_cg;
  if (keeps_air)
    for (Vectors& air : system.air) air.resize(state.x.size());
  TURGOR_CHECK(is_csr(model.component_begin, std::size_t(model.count)), "components cover all vertices");
  system.drag.assign(model.component_begin.size() - 1, 0);
  if (has_wind)
    blow(exec, inputs.air, state.time, dt, model.triangles, model.chunk_triangles, state.x, state.v,
         system.change, {system.force, system.inverse[0], system.inverse[1]});
  if (has_springs) {
    if (!has_wind)
      for (Vectors* terms : {&system.force, &system.inverse[0], &system.inverse[1]})
        for (std::size_t v = 0; v < terms->size(); v++) terms->set(v, {});
    add_vertex_springs(inputs.springs, state, dt, system.force, system.inverse[0], system.inverse[1]);
    add_vertex_loads(inputs.loads, dt, system.force);
  }
  if (has_air)
    for (std::size_t p = 0; p < system.drag.size(); p++)
      if (!IsComponentHeld{state.holds}(model.component_begin[p], model.component_begin[p + 1]))
        system.drag[p] =
            component_sum(exec, model.component_begin[p], model.component_begin[p + 1], [&](std::size_t v) {
              return double(system.inverse[0].x[v] + system.inverse[0].y[v] + system.inverse[0].z[v]);
            });
  // forces, matrix entries and inverse diagonal
  system.two_level.is_factored = false;
  if (model.params.fabric.law == Law::kSheet) find_tensions(exec, model, state);
  parallel_for(exec, batch_count(model.rows),
               AssembleRow<Lanes>{view(model, state), Vec3(inputs.gravity), Real(dt),
                                  Real(dt * damping.motion), has_air, keeps_air, uses_cg},
               kGrain);
  if (!uses_cg) add_impulses(state.contacts, state.free_mass, system.force);  // else they are implicit
  aim_holds(model, state, Real(dt));
}

void move_free_components(const Exec& exec, const Model& model, State& state, const Vectors& force,
                          double dt) {
  System& system = state.system;
  TURGOR_CHECK(system.drag.size() + 1 == model.component_begin.size(), "every component has a drag");
  for (std::size_t p = 0; p + 1 < model.component_begin.size(); p++) {
    const int begin = model.component_begin[p], end = model.component_begin[p + 1];
    if (IsComponentHeld{state.holds}(begin, end)) continue;
    const double mass = component_sum(exec, begin, end, [&](std::size_t v) { return double(model.mass[v]); });
    const Vec3d sum = component_sum(exec, begin, end, [&](std::size_t v) { return Vec3d(force[v]); });
    TURGOR_CHECK(mass > 0, "a component has a mass");
    const Vec3 all(sum / (mass * (1 + dt * model.params.damping.motion) + system.drag[p]));
    for (auto v = std::size_t(begin); v < std::size_t(end); v++) system.change.add(v, all);
  }
}

void start_change(const Exec& exec, const Model& model, State& state, double dt) {
  System& system = state.system;
  const std::size_t count = system.change.size();
  for (std::size_t v = 0; v < count; v++) system.change.set(v, {});
  system.previous = system.force;
  add_impulses(state.implicit_contacts.contacts, state.free_mass, system.previous);
  move_free_components(exec, model, state, system.previous, dt);
  for (std::size_t v = 0; v < count; v++) system.previous.set(v, system.change[v]);
  for_holds(state, StartHolds{view(model, state), state.holds.data()});
}

void sweep(const Exec& exec, const Model& model, State& state, Real omega) {
  parallel_for(exec, batch_count(model.rows), SweepRow<Lanes>{view(model, state), omega}, kGrain);
  std::swap(state.system.change, state.system.previous);
}

void solve_by_sweeps(const Exec& exec, const Model& model, State& state, Method method, int sweeps) {
  run_sweeps(
      method == Method::kChebyshev, sweeps, [&](Real omega) { sweep(exec, model, state, omega); },
      [&] { state.system.previous = state.system.change; });
}

// Residual forces of the sheet would be a large share of the forces on obstacles, so the tolerance of a sheet
// that presses one is a thirtieth. It is a tenth where only layers press each other: the residual of a stiff
// sheet would stop one that slides. Without closed contacts one solution is enough.
void solve_with_implicit_contacts(const Exec& exec, const Model& model, State& state, double dt) {
  // stop criterion and number of rounds
  constexpr int kRounds = 4, kSqueezedRounds = 10;
  constexpr double kObstacleCare = 0.03, kLayerCare = 0.1;
  const Solver& solver = model.params.solver;
  const auto& terms = state.implicit_contacts.terms;
  const bool is_squeezed = std::any_of(terms.begin(), terms.end(),
                                       [](const ImplicitContact& a) { return a.separation_speed > 0; });
  // solutions with a fixed active set
  int iterations = 0;
  for (int round = 0; round < (is_squeezed ? kSqueezedRounds : kRounds); round++) {
    const bool presses = any_closed(state.implicit_contacts);
    const double care = presses_obstacle(state.implicit_contacts) ? kObstacleCare : presses ? kLayerCare : 1;
    solve_by_conjugate_gradients(
        exec, model, state,
        {solver.sweeps, solver.tolerance * care, solver.method == Method::kTwoLevel, presses});
    iterations += state.system.iterations;
    if (terms.empty() || !update_active_set(model, state, dt)) break;
  }
  // residual momentum of free components
  state.system.iterations = iterations;
  if (!any_closed(state.implicit_contacts))
    move_free_components(exec, model, state, state.system.residual_vector, dt);
}

}  // namespace turgor::cloth
