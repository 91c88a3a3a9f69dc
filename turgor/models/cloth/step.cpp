#include "turgor/models/cloth/step.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/atomic_max.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/solver/implicit_contact.hpp"
#include "turgor/models/cloth/solver/motion_kernels.hpp"
#include "turgor/models/cloth/solver/strain_limit.hpp"
#include "turgor/models/cloth/solver/system.hpp"
#include "turgor/models/cloth/step_sequence.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 64;    // batches per task
constexpr int kMaxRewinds = 10;       // of a step for its collisions
constexpr std::size_t kLeastNew = 4;  // collisions for each that is no contact yet, at most

template <class Loop>
void for_batches(const Exec& exec, const State& state, const Loop& loop) {
  parallel_for(exec, state.v.size() / std::size_t(kLanes), loop, kGrain);
}

/// Largest speed [m/s]; not finite if any velocity is not. Bits of infinity and NaN are above all finite
/// ones.
Real largest_speed(const Exec& exec, const State& state) {
  std::uint32_t largest = 0;
  exec.run_ranges(state.v.size(), kGrain * std::size_t(kLanes), [&](std::size_t begin, std::size_t end) {
    std::uint32_t found = 0;
    for (std::size_t i = begin; i < end; i++) {
      const std::uint32_t bits = magnitude_bits(dot(state.v[i], state.v[i]));
      found = bits > found ? bits : found;
    }
    atomic_max(largest, found);
  });
  return std::sqrt(std::bit_cast<Real>(largest));
}

/// BDF2 predictor. With the last state x₁ and the one before it x₀, BDF2 requires
///
///   x = 4/3 x₁ − 1/3 x₀ + 2/3 h v,     v likewise.
///
/// This is a backward Euler step of length 2/3 h from the extrapolation 4/3 x₁ − 1/3 x₀, which replaces the
/// state. Returns 2/3 h. Without a last step of the same length the state is kept, and h is returned.
double predict_bdf2(const Exec& exec, State& state, double dt) {
  Bdf2History& last = state.history;
  const bool has_history = last.dt == dt;
  last.dt = dt;
  last.x.resize(state.x.size()), last.v.resize(state.v.size());
  for_batches(exec, state, PredictBdf2<Lanes>{view(state.x), view(last.x), has_history});
  for_batches(exec, state, PredictBdf2<Lanes>{view(state.v), view(last.v), has_history});
  return has_history ? dt * 2 / 3 : dt;
}

bool uses_bdf2(const Model& model) { return model.params.solver.integrator == Integrator::kBdf2; }

/// Restores the positions before the step with zero velocities, and clears contacts and history. Without BDF2
/// a failed step has not changed the positions.
void restore_last_state(State& state) {
  for (auto* values : {&state.v.x, &state.v.y, &state.v.z})
    std::fill(values->begin(), values->end(), Real(0));
  if (state.history.dt > 0) state.x = state.history.x;
  state.history.dt = 0;
  state.contacts.list.clear();
  state.contacts.begin.clear();
  state.largest_speed = 0;
}

/// Moves the vertices by v dt, and held vertices to their goals. Stores the positions before the step in
/// System::previous, for CCD.
void move(const Exec& exec, const Model& model, State& state, Real dt) {
  Vectors& from = uses_bdf2(model) ? state.history.x : state.x;
  TURGOR_CHECK(std::all_of(state.holds.begin(), state.holds.end(),
                           [&](const Hold& h) { return is_index(h.vertex, state.x.size()); }),
               "held vertices are of the cloth");
  for_batches(exec, state,
              Move<Lanes>{view(state.x), view(state.v), view(from), view(state.system.previous), dt});
  for_holds(state, MoveHolds{view(model, state), state.holds.data()});
}

/// Phases of a step on the host (step_sequence.hpp).
struct HostStep {
  const Exec& exec;
  const Model& model;
  State& state;
  const Inputs& inputs;
  double frame, dt = 0;  // [s]; dt is shorter with BDF2
  StepReport report = {};
  Vectors start_x = {}, start_v = {};    // positions and velocities that the linear system starts from
  std::vector<Contact> collisions = {};  // of earlier solutions of the step
  int rewinds = 0;
  bool may_collide = true;  // false: the latest search has found nothing

  bool uses_cg() const { return uses_conjugate_gradients(model.params.solver.method); }

  void predict() {
    dt = state.impulse_time = uses_bdf2(model) ? predict_bdf2(exec, state, frame) : frame;
    if (uses_cg() && model.params.collision.self) start_x = state.x, start_v = state.v;
  }
  void assemble() { cloth::assemble(exec, model, state, inputs, dt); }
  void start_change() { cloth::start_change(exec, model, state, dt); }

  // sweeps
  void sweep() {
    solve_by_sweeps(exec, model, state, model.params.solver.method, model.params.solver.sweeps);
  }
  void measure_residual() {
    if (inputs.measure_residual) report.residual = residual(exec, model, state);
  }

  // conjugate gradients
  void find_implicit_contacts() { cloth::find_implicit_contacts(exec, model, state, inputs, dt, collisions); }
  void solve_with_implicit_contacts() { cloth::solve_with_implicit_contacts(exec, model, state, dt); }
  void relinearize() {
    cloth::relinearize(exec, model, state, inputs, dt);
    report.iterations += state.system.iterations, report.residual = state.system.residual;
  }

  // velocities
  void change_velocities() {
    for_batches(exec, state, ChangeVelocities<Lanes>{view(state.v), view(state.system.change)});
  }
  void limit_strain() {
    if (model.params.solver.strain_limit > 0) cloth::limit_strain(exec, model, state, dt);
  }
  void measure_speed() {
    state.largest_speed = largest_speed(exec, state);
    if (uses_cg() && !std::isfinite(state.system.residual))
      state.largest_speed = NAN;  // a system that was not solved undoes the step
  }
  void solve_contact_impulses() {
    if (is_finite()) {
      find_contacts(exec, model, state, inputs, dt);
      report.contact_iterations = solve_velocities(exec, model, state, dt);
      state.largest_speed = largest_speed(exec, state);
    }
    report.finite = is_finite(), report.largest_speed = state.largest_speed;
    report.contacts = int(state.contacts.list.size());
  }
  bool is_finite() const { return std::isfinite(state.largest_speed); }
  void undo() { restore_last_state(state); }

  // positions
  void move() { cloth::move(exec, model, state, Real(dt)); }
  void solve_positions() { cloth::solve_positions(exec, model, state, dt); }
  /// Rewinds the step if its motion has collisions that are no contacts yet. They become contacts. Where most
  /// pairs that collide are contacts already, as in a knot that holds pull tight, another solution does not
  /// help.
  bool rewinds_for_collisions() {
    if (!model.params.collision.self || rewinds == kMaxRewinds) return false;
    may_collide = find_collisions(exec, model, state);
    const std::size_t before = collisions.size();
    if (may_collide) find_collision_contacts(model, state, start_x, collisions);
    if (kLeastNew * (collisions.size() - before) <= state.ccd.ccd_pairs.size()) return false;
    state.x = start_x, state.v = start_v;
    rewinds++;
    return true;
  }
  void resolve_ccd() {
    if (model.params.collision.self && may_collide)
      report.in_impact_zone = cloth::resolve_ccd(exec, model, state);
  }
  void advance_time() { state.time += frame; }
};

}  // namespace

StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double frame) {
  TURGOR_CHECK(is_step_length(frame), "a step has a positive length");
  HostStep sheet{exec, model, state, inputs, frame};
  sheet.uses_cg() ? step_cg(sheet) : step_sweeps(sheet);
  return sheet.report;
}

}  // namespace turgor::cloth
