#include "turgor/models/cloth/system.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/cloth/batch_system.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 16;  // batches

/// Springs around sixteen vertices: their force, viscous part included, their matrix entries, and the inverse
/// of the diagonal block.
struct AssembleBatch {
  const Model& model;
  State& state;
  Vec3 gravity;
  Real dt, s, keep;  // s = h² + h·stretch damping; keep = h·motion damping
  bool has_air, keeps_air;

  void add_springs(std::size_t batch, const Lanes3& x, const Lanes3& v, Lanes is_free, Lanes3& f,
                   LanesMatrix& d) const {
    const Rows& rows = model.rows;
    System& system = state.system;
    for (int slot = rows.slot_begin[batch]; slot < rows.slot_begin[batch + 1]; slot++) {
      const auto entry = std::size_t(slot) * std::size_t(kLanes);
      const Lanes3 e = load_neighbours(rows, state.x, slot) - x, u = load_neighbours(rows, state.v, slot) - v;
      const Lanes k = load_lanes(&rows.stiffness[entry]);
      const Lanes length2 = larger(dot(e, e), all_lanes(1e-20f));
      const Lanes stretch = 1 - load_lanes(&rows.rest[entry]) / square_root(length2);
      // Compressed springs lose the part across them, so that W stays positive definite. [Kang III]
      const Lanes across = k * s * larger(stretch, all_lanes(0));
      const Lanes along = (k * s - across) / length2;
      f = f + e * (k * dt * stretch + along * dot(e, u)) + u * across;
      d.diagonal = d.diagonal +
                   Lanes3{along * e.x * e.x + across, along * e.y * e.y + across, along * e.z * e.z + across};
      d.off = d.off + Lanes3{along * e.x * e.y, along * e.x * e.z, along * e.y * e.z};
      store_lanes(&system.along[entry], along * is_free);
      store_lanes(&system.across[entry], across * is_free);
    }
  }

  /// The tensions of the membrane are in `across`. Its stiffness is bounded by springs along the edges; those
  /// that are pushed lose the part across them, as springs do.
  void add_sheet(std::size_t batch, const Lanes3& x, const Lanes3& v, Lanes is_free, Lanes3& f,
                 LanesMatrix& d) const {
    const Rows &rows = model.rows, &far = model.far_rows;
    System& system = state.system;
    const Lanes spare = load_lanes(&model.spare[batch * std::size_t(kLanes)]) * s;
    Lanes sum = spare;
    for (int slot = rows.slot_begin[batch]; slot < rows.slot_begin[batch + 1]; slot++) {
      const auto entry = std::size_t(slot) * std::size_t(kLanes);
      const Lanes3 e = load_neighbours(rows, state.x, slot) - x, u = load_neighbours(rows, state.v, slot) - v;
      const Lanes tension = load_lanes(&system.across[entry]), bend = load_lanes(&rows.bend[entry]);
      const Lanes across = (larger(tension, all_lanes(0)) + bend) * s;
      const Lanes along = load_lanes(&rows.stiffness[entry]) * s / larger(dot(e, e), all_lanes(1e-20f));
      f = f + e * ((tension + bend) * dt + along * dot(e, u)) + u * across;
      d.diagonal = d.diagonal + Lanes3{along * e.x * e.x, along * e.y * e.y, along * e.z * e.z};
      d.off = d.off + Lanes3{along * e.x * e.y, along * e.x * e.z, along * e.y * e.z};
      sum = sum + across;
      store_lanes(&system.along[entry], along * is_free);
      store_lanes(&system.across[entry], across * is_free);
    }
    for (int slot = far.slot_begin[batch]; slot < far.slot_begin[batch + 1]; slot++) {
      const Lanes3 e = load_neighbours(far, state.x, slot) - x, u = load_neighbours(far, state.v, slot) - v;
      const Lanes bend = load_lanes(&far.bend[std::size_t(slot) * std::size_t(kLanes)]);
      f = f + e * (bend * dt) + u * (bend * s);
      sum = sum + bend * s;
    }
    d.diagonal = d.diagonal + Lanes3{sum, sum, sum};
  }

  void operator()(std::size_t batch) const {
    const std::size_t i = batch * std::size_t(kLanes);
    System& system = state.system;
    const Lanes3 x = load(state.x, i), v = load(state.v, i);
    const Lanes mass = load_lanes(&state.free_mass[i]);
    const Lanes is_free = mass > 0 ? all_lanes(1) : all_lanes(0);
    LanesMatrix d{{mass * (1 + keep), mass * (1 + keep), mass * (1 + keep)}, {}};
    Lanes3 f =
        Lanes3{mass * gravity.x, mass * gravity.y, mass * gravity.z} * all_lanes(dt) - v * (mass * keep);
    if (keeps_air)
      for (int k = 0; k < 2; k++)
        store(system.air[k], i, has_air ? load(system.inverse[k], i) * is_free : Lanes3{});
    if (has_air) {
      f = f + load(system.force, i);
      d.diagonal = d.diagonal + load(system.inverse[0], i), d.off = d.off + load(system.inverse[1], i);
    }
    if (model.params.fabric.law == Law::kSprings)
      add_springs(batch, x, v, is_free, f, d);
    else
      add_sheet(batch, x, v, is_free, f, d);
    const Lanes is_held = 1 - is_free;  // whose row says: the change is the given one
    d = {d.diagonal * is_free + Lanes3{is_held, is_held, is_held}, d.off * is_free};
    const LanesMatrix inverted = inverse(d);
    store(system.inverse[0], i, inverted.diagonal), store(system.inverse[1], i, inverted.off);
    store(system.force, i, f * is_free);
  }
};

/// Impulses of contacts: known from the step before, so that what lies still need not find them again.
void add_contact_impulses(State& state) {
  for (const Contact& c : state.contacts.list) {
    if (!(c.impulse > 0)) continue;
    for (std::size_t k = 0; k < 4; k++) {
      if (c.vertex[k] < 0) continue;
      const auto v = std::size_t(c.vertex[k]);
      if (state.free_mass[v] > 0)
        state.system.force.add(v, (c.normal * c.impulse + c.rub) * (c.carry * c.weight[k]));
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
               AssembleBatch{model, state, Vec3(inputs.gravity), Real(dt), system.square,
                             Real(dt * damping.motion), has_air, keeps_air},
               kGrain);
  if (!uses_gradients(model.params.solver.method)) add_contact_impulses(state);  // else: bearing.hpp
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
  System& system = state.system;
  parallel_for(
      exec, batch_count(model.rows),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        const Lanes3 sum = with_neighbours(model, state, system.change, i, load(system.force, i));
        const Lanes3 before = load(system.before, i);
        const Lanes3 jacobi = inverse_diagonal(system, i) * sum;
        store(system.before, i, before + (jacobi - before) * all_lanes(omega));
      },
      kGrain);
  std::swap(system.change, system.before);
}

void solve_by_sweeps(const Exec& exec, const Model& model, State& state, Method method, int sweeps) {
  int left = sweeps + 1;  // the paper's start, W_ii⁻¹ h f̃, is a sweep too
  if (left % 2 == 1) {    // errors of alternating sign would come out doubled [docs/models/cloth.md]
    sweep(exec, model, state, Real(0.5));
    left--;
    state.system.before = state.system.change;
  }
  if (method == Method::kJacobi) {
    for (; left > 0; left--) sweep(exec, model, state, 1);
    return;
  }
  // Eigenvalues of the iteration in [-rho, rho] lose all but 1/(2 + sweeps) of their error, none grows, and
  // the slow ones above rho gain as much as they can.
  const double rho = 1 / std::cosh(std::acosh(2.0 + left) / left);
  double omega = 1;
  for (int n = 0; n < left; n++) {
    sweep(exec, model, state, Real(omega));
    omega = n == 0 ? 2 / (2 - rho * rho) : 4 / (4 - rho * rho * omega);
  }
}

// What is left of stiff forces would be much of the force of a contact: there is less left of them.
void solve_with_bearing(const Exec& exec, const Model& model, State& state, double dt) {
  constexpr int kRounds = 4, kSqueezedRounds = 10;
  constexpr double kCare = 0.1;
  const Solver& solver = model.params.solver;
  const bool is_borne = !state.bearing.contacts.list.empty();
  const Stop stop{solver.sweeps, solver.tolerance * (is_borne ? kCare : 1), solver.method == Method::kBlocks};
  const auto& answers = state.bearing.answer;
  const bool is_squeezed =
      std::any_of(answers.begin(), answers.end(), [](const Answer& a) { return a.out > 0; });
  int iterations = 0;
  for (int round = 0; round < (is_squeezed ? kSqueezedRounds : kRounds); round++) {
    solve_by_conjugate_gradients(exec, model, state, stop);
    iterations += state.system.iterations;
    if (!is_borne || !settle_bearing(model, state, dt)) break;
  }
  state.system.iterations = iterations;
  if (!is_borne) move_free_parts(exec, model, state, state.system.left, dt);
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
