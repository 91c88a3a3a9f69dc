// A step is linear: what turns an edge, it takes for nothing, however far, and a sheet that lands fast on
// something small would be as much too long a step later as its edges were turned. Where obstacles stop it,
// such a step is solved again around where it leads [Newton].
#include <algorithm>
#include <cmath>

#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 16;  // batches

/// How much longer edges become on a way than its beginning says, at most, of their length at rest [1].
Real turned_by(const Model& model, const Vectors& from, const Vectors& to) {
  const Rows& rows = model.rows;
  Lanes most{};
  for (std::size_t batch = 0; batch < batch_count(rows); batch++) {
    const std::size_t i = batch * std::size_t(kLanes);
    const Lanes3 x = load(from, i), y = load(to, i), z = load(model.x_rest, i);
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
      const Lanes3 e = load_neighbors(rows, from, s) - x, after = load_neighbors(rows, to, s) - y;
      const Lanes length = square_root(larger(dot(e, e), all_lanes(1e-20f)));
      const Lanes said = dot(e, after) / length, is = square_root(dot(after, after));
      const Lanes3 at_rest = load_neighbors(rows, model.x_rest, s) - z;
      const Lanes rest2 = dot(at_rest, at_rest), more = is - larger(said, -said);
      most = larger(most, rest2 > 0 ? more / square_root(rest2) : all_lanes(0));
    }
  }
  Real largest = 0;
  for (int l = 0; l < kLanes; l++) largest = std::max(largest, most[l]);
  return largest;
}

/// Where the solution leads in the step.
void lead(const Exec& exec, const Vectors& x, const Vectors& v, const Vectors& change, Real dt, Vectors& to) {
  to.resize(x.size());
  parallel_for(
      exec, x.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        store(to, i, load(x, i) + (load(v, i) + load(change, i)) * all_lanes(dt));
      },
      kGrain);
}

// Around a change c of velocities, force F at places x' = x + h (v + c), and J there:
// (M − s J) Δ = h F + s J u with u = v − h²/s (v + c), as s = h² + h·damping and h² of it is measured from
// x'. What resists velocities themselves (air, damping of motion) is then told of u, and is owed v − u.
void assemble_around(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt,
                     const Vectors& v, const Vectors& change) {
  System& system = state.system;
  const Real part = Real(dt * dt) / system.square, rate = system.keep - 1;
  for (std::size_t i = 0; i < v.size(); i++) state.v.set(i, v[i] - (v[i] + change[i]) * part);
  assemble(exec, model, state, inputs, dt);
  parallel_for(
      exec, v.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        const Lanes3 owed = load(state.v, i) - load(v, i);
        const LanesMatrix air{load(system.air[0], i), load(system.air[1], i)};
        const Lanes mass = load_lanes(&state.free_mass[i]);
        store(system.force, i,
              load(system.force, i) +
                  (owed * (mass * rate) + air * owed) * (mass > 0 ? all_lanes(1) : all_lanes(0)));
      },
      kGrain);
}

/// Between a tool and a body that gives way a frame later, contacts are soft (implicit_contact.cpp), and a
/// sheet that is led out of there step by step turns as they let it.
bool may_be_squeezed(const Inputs& inputs) {
  return inputs.obstacles.size() > 1 && std::any_of(inputs.obstacles.begin(), inputs.obstacles.end(),
                                                    [](const Obstacle& o) { return o.compliance > 0; });
}

}  // namespace

void solve_what_turned(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  constexpr int kMost = 4;
  constexpr Real kTurned = Real(0.005);
  if (state.implicit_contacts.contacts.list.empty() || may_be_squeezed(inputs)) return;
  System& system = state.system;
  Vectors ahead, x, v;
  lead(exec, state.x, state.v, system.change, Real(dt), ahead);
  if (turned_by(model, state.x, ahead) < kTurned) return;
  x = state.x, v = state.v;
  int iterations = system.iterations;
  for (int n = 0; n < kMost; n++) {
    const Vectors change = system.change;
    state.x = ahead;
    assemble_around(exec, model, state, inputs, dt, v, change);
    state.v = v, system.change = change;
    stiffen_bearing(state);
    solve_with_bearing(exec, model, state, dt);
    iterations += system.iterations;
    lead(exec, x, v, system.change, Real(dt), ahead);
    if (turned_by(model, state.x, ahead) < kTurned) break;
  }
  state.x = x, system.iterations = iterations;
}

}  // namespace turgor::cloth
