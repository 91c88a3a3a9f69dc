// Relinearization. A linear step ignores the rotation of edges, so a sheet that lands fast on a small object
// has edges that are too long after it. If obstacles stop the sheet, the step is solved again around its
// result [Newton].
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/forces/vertex_springs.hpp"
#include "turgor/models/cloth/solver/implicit_contact.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 16;  // batches

/// Largest error of linearization: length of an edge after the motion minus its projection onto the initial
/// direction, relative to the rest length [1].
Real linearization_error(const Model& model, const Vectors& from, const Vectors& to) {
  const Rows& rows = model.rows;
  Lanes most{};
  // excess of each edge over its linear prediction
  for (std::size_t batch = 0; batch < batch_count(rows); batch++) {
    const std::size_t i = batch * std::size_t(kLanes);
    const Lanes3 x = load(from, i), y = load(to, i), z = load(model.x_rest, i);
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
      const Lanes3 e = load_neighbors(rows, from, s) - x, after = load_neighbors(rows, to, s) - y;
      const Lanes length = square_root(larger(dot(e, e), all_lanes(1e-20f)));
      const Lanes projected = dot(e, after) / length, length_after = square_root(dot(after, after));
      const Lanes3 at_rest = load_neighbors(rows, model.x_rest, s) - z;
      const Lanes rest2 = dot(at_rest, at_rest), more = length_after - larger(projected, -projected);
      most = larger(most, rest2 > 0 ? more / square_root(rest2) : all_lanes(0));
    }
  }
  // largest of the lanes
  Real largest = 0;
  for (int l = 0; l < kLanes; l++) largest = std::max(largest, most[l]);
  return largest;
}

/// Positions at the end of the step that the solution predicts.
void predict_positions(const Exec& exec, const Vectors& x, const Vectors& v, const Vectors& change, Real dt,
                       Vectors& to) {
  to.resize(x.size());
  parallel_for(
      exec, x.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        store(to, i, load(x, i) + (load(v, i) + load(change, i)) * all_lanes(dt));
      },
      kGrain);
}

// System around a velocity change c, with force F and J at x' = x + h (v + c):
//
//   (M − s J) Δ = h F + s J u,     u = v − h²/s (v + c)
//
// since s = h² + h β, and h² of it is measured from x'. Terms that resist velocities (wind, damping of
// motion) are assembled with u, so their force is corrected by v − u.
void assemble_around(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt,
                     const Vectors& v, const Vectors& change) {
  System& system = state.system;
  TURGOR_CHECK(system.stiffness_factor > 0, "the system was assembled before");
  const Real ratio = Real(dt * dt) / system.stiffness_factor, motion_damping = system.mass_factor - 1;
  for (std::size_t i = 0; i < v.size(); i++) state.v.set(i, v[i] - (v[i] + change[i]) * ratio);
  assemble(exec, model, state, inputs, dt);
  parallel_for(
      exec, v.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        const Lanes3 correction = load(state.v, i) - load(v, i);
        const LanesMatrix air{load(system.air[0], i), load(system.air[1], i)};
        const Lanes mass = load_lanes(&state.free_mass[i]);
        store(system.force, i,
              load(system.force, i) + (correction * (mass * motion_damping) + air * correction) *
                                          (mass > 0 ? all_lanes(1) : all_lanes(0)));
      },
      kGrain);
  // springs of vertices resist displacements, as those of the fabric do
  for (const VertexSpring& spring : inputs.springs) {
    const auto i = std::size_t(spring.vertex);
    if (!(state.free_mass[i] > 0)) continue;
    const Vec3 correction = state.v[i] - v[i];
    system.force.add(i,
                     spring_force(spring, state.x[i]).stiffness_times(correction) * -system.stiffness_factor);
  }
}

/// True if cloth may be squeezed between a tool and a body that yields a frame later. Its contacts are soft
/// (implicit_contact.cpp), and the sheet may rotate freely as they remove the penetration.
bool may_be_squeezed(const Inputs& inputs) {
  return inputs.obstacles.size() > 1 && std::any_of(inputs.obstacles.begin(), inputs.obstacles.end(),
                                                    [](const Obstacle& o) { return o.compliance > 0; });
}

}  // namespace

void relinearize(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  constexpr int kMaxIterations = 4;
  constexpr Real kErrorLimit = Real(0.005);
  // no obstacle stops the sheet, or small rotation: one solution is enough
  if (!presses_obstacle(state.implicit_contacts) || may_be_squeezed(inputs)) return;
  System& system = state.system;
  Vectors predicted, x, v;
  predict_positions(exec, state.x, state.v, system.change, Real(dt), predicted);
  if (linearization_error(model, state.x, predicted) < kErrorLimit) return;
  // Newton iterations around the predicted positions
  x = state.x, v = state.v;
  int iterations = system.iterations;
  for (int n = 0; n < kMaxIterations; n++) {
    const Vectors change = system.change;
    state.x = predicted;
    assemble_around(exec, model, state, inputs, dt, v, change);
    state.v = v, system.change = change;
    add_contacts_to_diagonal(state);
    solve_with_implicit_contacts(exec, model, state, dt);
    iterations += system.iterations;
    predict_positions(exec, x, v, system.change, Real(dt), predicted);
    if (linearization_error(model, state.x, predicted) < kErrorLimit) break;
  }
  // positions at the beginning of the step
  state.x = x, system.iterations = iterations;
}

}  // namespace turgor::cloth
