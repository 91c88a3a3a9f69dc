// Equilibrium of rotated elements by alternating steps. With fixed rotations, the displacements solve a
// linear system by conjugate gradients with the factor of K as preconditioner. Then the rotations follow the
// displacements.
#include "turgor/models/sfem/rotation.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/cholesky.hpp"

namespace turgor::sfem {

namespace {

using Vector = std::vector<double>;

double product(const Vector& a, const Vector& b) {
  TURGOR_CHECK(a.size() == b.size(), "both vectors have one length");
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i++) sum += a[i] * b[i];
  return sum;
}

/// y += s x
void add(double s, const Vector& x, Vector& y) {
  TURGOR_CHECK(x.size() == y.size(), "both vectors have one length");
  for (std::size_t i = 0; i < x.size(); i++) y[i] += s * x[i];
}

struct Equilibrium {
  const Exec& exec;
  const Model& model;
  const Corotation& corotation;
  Vector forces;  // by free node [N]
};

/// Residual forces [N], the linear body's response to them [m], and their energy [J].
struct Imbalance {
  Vector forces, answer;
  double energy = 0;
};

Imbalance find_imbalance(const Equilibrium& e, const RotationState& state) {
  Vector inside(e.forces.size());
  element_forces(e.exec, e.model, e.corotation, state.rotation, state.u, inside);
  Imbalance now{e.forces, {}, 0};
  add(-1, inside, now.forces);
  now.answer = now.forces;
  solve(*e.model.factor, now.answer);
  now.energy = product(now.forces, now.answer);
  return now;
}

/// Displacement that balances the forces with fixed rotations. Uses at most `solves` preconditioned conjugate
/// gradient steps, or stops when little of the energy is left. Returns the number of solves.
int balance(const Equilibrium& e, Imbalance missing, int solves, RotationState& state) {
  const double enough = 1e-4 * missing.energy;  // the acceleration learns little from rounds less exact
  Vector direction = missing.answer, resistance(direction.size());
  for (int used = 0;; used++) {
    turned_stiffness_times(e.exec, e.model, e.corotation, state.rotation, direction, resistance);
    const double step = missing.energy / product(direction, resistance);
    add(step, direction, state.u);
    if (used == solves) return used;
    add(-step, resistance, missing.forces);
    missing.answer = missing.forces;
    solve(*e.model.factor, missing.answer);
    const double energy = product(missing.forces, missing.answer);
    if (energy < enough) return used + 1;
    for (std::size_t i = 0; i < direction.size(); i++)
      direction[i] = missing.answer[i] + energy / missing.energy * direction[i];
    missing.energy = energy;
  }
}

/// Anderson acceleration of a round's step: the combination of earlier rounds that would have left the
/// smallest step. [Anderson 1965; Peng et al. 2018]
Vector accelerated(const Vector& u, const Vector& step, RoundHistory& history) {
  constexpr std::size_t kMost = 6;
  const auto change = [](Vector now, const Vector& before) {
    add(-1, before, now);
    return now;
  };
  if (!history.u.empty()) {
    history.moves.push_back(change(u, history.u));
    history.changes.push_back(change(step, history.step));
  }
  history.u = u, history.step = step;
  if (history.moves.size() > kMost) {
    history.moves.erase(history.moves.begin());
    history.changes.erase(history.changes.begin());
  }
  if (history.moves.empty()) return step;
  const auto columns = Eigen::Index(history.moves.size()), rows = Eigen::Index(step.size());
  Eigen::MatrixXd changes(rows, columns);
  for (Eigen::Index c = 0; c < columns; c++)
    changes.col(c) = Eigen::Map<const Eigen::VectorXd>(history.changes[std::size_t(c)].data(), rows);
  const Eigen::VectorXd weight =
      changes.colPivHouseholderQr().solve(Eigen::Map<const Eigen::VectorXd>(step.data(), rows));
  Vector better = step;
  for (Eigen::Index c = 0; c < columns; c++) {
    add(-weight[c], history.moves[std::size_t(c)], better);
    add(-weight[c], history.changes[std::size_t(c)], better);
  }
  return better;
}

/// Largest rotation of an element by a step, approximately [rad].
double largest_turn(const Model& model, const Corotation& corotation, const Vector& step) {
  const SolidMesh& mesh = model.body.mesh;
  const auto corners = std::size_t(mesh.corners);
  double largest = 0;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    // rotation vector: half of the curl of the displacement
    Vec3d curl;
    for (std::size_t c = 0; c < corners; c++) {
      const int row = model.free_node[std::size_t(element(mesh, e)[c])];
      if (row < 0) continue;
      const double* u = &step[3 * std::size_t(row)];
      curl += cross(corotation.gradient[corners * e + c], Vec3d{u[0], u[1], u[2]});
    }
    largest = std::max(largest, norm(curl) / 2);
  }
  return largest;
}

/// One round: balances the forces with fixed rotations, then updates the rotations. Returns the number of
/// solves.
int play_round(const Equilibrium& e, const Imbalance& now, int solves, RotationState& state) {
  constexpr double kMostTurn =
      0.5;  // largest rotation of an element in a round, so that none leaves its basin [rad]
  const Vector before = state.u;
  const int used = balance(e, now, solves, state);
  Vector step = state.u;
  add(-1, before, step);
  step = accelerated(before, step, state.history);
  const double turn = largest_turn(e.model, e.corotation, step);
  state.u = before;
  add(turn > kMostTurn ? kMostTurn / turn : 1, step, state.u);
  update_rotations(e.exec, e.model, e.corotation, state.u, state.rotation);
  return used;
}

void spread_to_vertices(const Model& model, const Vector& u, const Vector& linear, RotationState& state) {
  for (std::size_t row = 0; row < model.vertex.size(); row++) {
    const auto v = std::size_t(model.vertex[row]);
    for (int axis = 0; axis < 3; axis++) {
      const std::size_t i = 3 * row + std::size_t(axis);
      state.displacement[v][axis] = u[i];
      state.free[v][axis] = u[i] - linear[i];
    }
  }
}

}  // namespace

RotationState make_rotation_state(const Model& model) {
  const std::size_t vertices = model.body.mesh.vertices.size();
  RotationState state;
  state.rotation.resize(element_count(model.body.mesh));
  state.u.assign(3 * model.vertex.size(), 0);
  state.displacement.resize(vertices);
  state.free.resize(vertices);
  return state;
}

RotationReport correct_rotations(const Exec& exec, const Model& model, const Corotation& corotation,
                                 std::span<const Vec3d> forces, const RotationParams& params,
                                 RotationState& state) {
  constexpr int kPatience = 50;  // rounds without progress
  TURGOR_CHECK(forces.size() == model.body.mesh.vertices.size(), "every vertex has a force");
  TURGOR_ASSERT(model.factor.has_value(), "rotations are corrected with the factor");
  Equilibrium e{exec, model, corotation, {}};
  for (const int v : model.vertex)
    for (int axis = 0; axis < 3; axis++) e.forces.push_back(forces[std::size_t(v)][axis]);
  if (e.forces != state.forces) {
    state.forces = e.forces;
    state.history.u.clear();  // the next round does not continue the last one
    state.idle = 0;
  }
  Vector linear = e.forces;
  solve(*model.factor, linear);
  if (product(e.forces, linear) == 0) {  // at rest
    state = make_rotation_state(model);
    return {.solves = 1, .converged = true};
  }

  RotationReport report{.solves = 2};
  Imbalance now = find_imbalance(e, state);
  const double scale = std::max(product(e.forces, linear), now.energy);
  Vector best = state.u;
  for (double least = now.energy;;) {
    report.residual = scale > 0 ? std::sqrt(least / scale) : 0;
    report.converged = report.residual <= params.tolerance;
    report.stuck = !report.converged && state.idle >= kPatience;
    if (report.converged || report.stuck || report.solves + 2 > params.most_solves) break;
    report.solves += play_round(e, now, params.most_solves - report.solves - 1, state);
    const double before = now.energy;
    now = find_imbalance(e, state);
    report.solves++;
    if (!(now.energy <= before)) state.history = {};  // the history does not apply to this region
    state.idle = now.energy < least ? 0 : state.idle + 1;
    if (now.energy < least) least = now.energy, best = state.u;
  }
  spread_to_vertices(model, best, linear, state);
  return report;
}

}  // namespace turgor::sfem
