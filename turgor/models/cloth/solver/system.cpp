#include "turgor/models/cloth/solver/system.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/cloth/solver/system_kernels.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 16;  // batches

/// Impulses of contacts: known from the step before, so that what lies still need not find them again.
void add_contact_impulses(State& state) {
  for (const Contact& c : state.contacts.list) {
    if (!(c.impulse > 0)) continue;
    for (std::size_t k = 0; k < 4; k++) {
      if (c.vertex[k] < 0) continue;
      const auto v = std::size_t(c.vertex[k]);
      if (state.free_mass[v] > 0)
        state.system.force.add(v, (c.normal * c.impulse + c.friction_impulse) * (c.warm_start * c.weight[k]));
    }
  }
}

void aim_holds(State& state, Real dt) {
  for (const Hold& hold : state.holds) {
    const auto v = std::size_t(hold.vertex);
    state.system.force.set(v, (hold.goal - state.x[v]) / dt - state.v[v]);
  }
}

/// Sums over the vertices of a part, in pieces that are always the same.
template <class Term>
auto part_sum(const Exec& exec, int begin, int end, const Term& term) {
  constexpr int kPiece = 4096;
  std::vector<decltype(term(0))> pieces(std::size_t((end - begin + kPiece - 1) / kPiece));
  parallel_for(exec, pieces.size(), [&](std::size_t p) {
    const int from = begin + int(p) * kPiece;
    for (int v = from; v < std::min(from + kPiece, end); v++) pieces[p] += term(std::size_t(v));
  });
  decltype(term(0)) sum{};
  for (const auto piece : pieces) sum += piece;
  return sum;
}

struct IsPartHeld {
  const std::vector<Hold>& holds;

  bool operator()(int begin, int end) const {
    const auto first = std::lower_bound(holds.begin(), holds.end(), begin,
                                        [](const Hold& h, int v) { return h.vertex < v; });
    return first != holds.end() && first->vertex < end;
  }
};

}  // namespace

SheetView view(const Model& model, State& state) {
  System& system = state.system;
  return {.size = state.x.size(),
          .rows = view(model.rows),
          .far = view(model.far_rows),
          .spare = model.spare.empty() ? nullptr : model.spare.data(),
          .x_rest = view(model.x_rest),
          .x = view(state.x),
          .v = view(state.v),
          .free_mass = state.free_mass.data(),
          .along = system.along.data(),
          .across = system.across.data(),
          .force = view(system.force),
          .inverse = {view(system.inverse[0]), view(system.inverse[1])},
          .change = view(system.change),
          .before = view(system.before),
          .air = {view(system.air[0]), view(system.air[1])},
          .square = system.square};
}

void assemble(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  System& system = state.system;
  const bool has_air = inputs.air.density > 0;
  const bool keeps_air = inputs.measure_residual || uses_gradients(model.params.solver.method);
  if (keeps_air)
    for (Vectors& air : system.air) air.resize(state.x.size());
  system.drag.assign(model.part_begin.size() - 1, 0);
  if (has_air) {
    blow(exec, inputs.air, state.time, dt, model.triangles, model.chunk_triangles, state.x, state.v,
         system.change, {system.force, system.inverse[0], system.inverse[1]});
    for (std::size_t p = 0; p < system.drag.size(); p++)
      if (!IsPartHeld{state.holds}(model.part_begin[p], model.part_begin[p + 1]))
        system.drag[p] = part_sum(exec, model.part_begin[p], model.part_begin[p + 1], [&](std::size_t v) {
          return double(system.inverse[0].x[v] + system.inverse[0].y[v] + system.inverse[0].z[v]);
        });
  }
  const Damping& damping = model.params.damping;
  system.keep = Real(1 + dt * damping.motion), system.square = Real(dt * dt + dt * damping.stretch);
  if (model.params.fabric.law == Law::kSheet) find_tensions(exec, model, state);
  parallel_for(exec, batch_count(model.rows),
               AssembleRow<Lanes>{view(model, state), Vec3(inputs.gravity), Real(dt),
                                  Real(dt * damping.motion), has_air, keeps_air},
               kGrain);
  if (!uses_gradients(model.params.solver.method)) add_contact_impulses(state);  // else: implicit_contact.hpp
  aim_holds(state, Real(dt));
}

void move_free_parts(const Exec& exec, const Model& model, State& state, const Vectors& force, double dt) {
  System& system = state.system;
  for (std::size_t p = 0; p + 1 < model.part_begin.size(); p++) {
    const int begin = model.part_begin[p], end = model.part_begin[p + 1];
    if (IsPartHeld{state.holds}(begin, end)) continue;
    const double mass = part_sum(exec, begin, end, [&](std::size_t v) { return double(model.mass[v]); });
    const Vec3d sum = part_sum(exec, begin, end, [&](std::size_t v) { return Vec3d(force[v]); });
    const Vec3 all(sum / (mass * (1 + dt * model.params.damping.motion) + system.drag[p]));
    for (auto v = std::size_t(begin); v < std::size_t(end); v++) system.change.add(v, all);
  }
}

void start_change(const Exec& exec, const Model& model, State& state, double dt) {
  System& system = state.system;
  const std::size_t count = system.change.size();
  for (std::size_t v = 0; v < count; v++) system.change.set(v, {});
  move_free_parts(exec, model, state, system.force, dt);
  for (std::size_t v = 0; v < count; v++) system.before.set(v, system.change[v]);
  for (const Hold& hold : state.holds) {
    const auto v = std::size_t(hold.vertex);
    system.change.set(v, system.force[v]), system.before.set(v, system.force[v]);
  }
}

void sweep(const Exec& exec, const Model& model, State& state, Real omega) {
  parallel_for(exec, batch_count(model.rows), SweepRow<Lanes>{view(model, state), omega}, kGrain);
  std::swap(state.system.change, state.system.before);
}

void solve_by_sweeps(const Exec& exec, const Model& model, State& state, Method method, int sweeps) {
  go_through_sweeps(
      method == Method::kChebyshev, sweeps, [&](Real omega) { sweep(exec, model, state, omega); },
      [&] { state.system.before = state.system.change; });
}

// What is left of stiff forces would be much of the force of a contact: there is less left of them.
void solve_with_bearing(const Exec& exec, const Model& model, State& state, double dt) {
  constexpr int kRounds = 4, kSqueezedRounds = 10;
  constexpr double kCare = 0.1;
  const Solver& solver = model.params.solver;
  const bool is_implicit = !state.implicit_contacts.contacts.list.empty();
  const Stop stop{solver.sweeps, solver.tolerance * (is_implicit ? kCare : 1),
                  solver.method == Method::kBlocks};
  const auto& answers = state.implicit_contacts.answer;
  const bool is_squeezed =
      std::any_of(answers.begin(), answers.end(), [](const ImplicitContact& a) { return a.out > 0; });
  int iterations = 0;
  for (int round = 0; round < (is_squeezed ? kSqueezedRounds : kRounds); round++) {
    solve_by_conjugate_gradients(exec, model, state, stop);
    iterations += state.system.iterations;
    if (!is_implicit || !update_active_set(model, state, dt)) break;
  }
  state.system.iterations = iterations;
  if (!is_implicit) move_free_parts(exec, model, state, state.system.left, dt);
}

void solve_change(const Exec& exec, const Model& model, State& state, double dt) {
  const Solver& solver = model.params.solver;
  start_change(exec, model, state, dt);
  if (uses_gradients(solver.method)) {
    solve_with_bearing(exec, model, state, dt);
  } else {
    solve_by_sweeps(exec, model, state, solver.method, solver.sweeps);
  }
}

}  // namespace turgor::cloth
