// One step of the lattice model: coarse space, sleep, predictor, sweeps with coarse corrections, velocities.
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/coarse/coupled_points.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/solver/balance_momentum.hpp"
#include "turgor/models/lattice/solver/calm_rows.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/step_sequence.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"

namespace turgor::lattice {

namespace {

void check_contacts(const Model& model, const Inputs& inputs) {
  const std::span<const NodeContact> contacts = inputs.contacts;
  TURGOR_ASSERT(inputs.points == nullptr || inputs.points->at.size() == contacts.size(),
                "every contact has a point");
  TURGOR_ASSERT(contacts.empty() || model.params.solver.method == Method::kVbd,
                "contacts need the VBD solver");
  for (std::size_t c = 0; c < contacts.size(); c++) {
    const auto slot = std::size_t(contacts[c].slot);
    TURGOR_ASSERT(c == 0 || inputs.points || contacts[c - 1].slot <= contacts[c].slot,
                  "the slots of contacts ascend");
    TURGOR_ASSERT(slot < model.anatomy.inverse_mass.size() && model.anatomy.inverse_mass[slot] > 0,
                  "contacts act on free nodes");
  }
}

void check_springs(const Model& model, const Inputs& inputs) {
  if (inputs.springs == nullptr) return;
  TURGOR_ASSERT(model.params.solver.method == Method::kVbd, "springs at points need the VBD solver");
  TURGOR_ASSERT(inputs.halo == nullptr, "springs at points need the whole body in one process");
  TURGOR_CHECK(is_ascending(inputs.springs->terms, &PointSpringTerm::corner),
               "the corners of springs ascend");
}

/// Difference to 1 of the step length of a full correction. The operator of the undeformed body then has the
/// body's stiffness, and a second correction would bring little (docs/performance.md).
constexpr double kFullStep = 0.2;

struct StepPlan {
  bool has_coarse_space = false;
  bool may_sleep = false;
  bool corrects = false;  // applies coarse corrections
  bool measures = false;  // measures the residual
};

/// Prepares the coarse space, wakes rows, and decides on coarse corrections and measurements.
StepPlan prepare_step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  StepPlan plan;
  plan.has_coarse_space = prepare_coarse_space(model, state, inputs, dt, exec);
  plan.may_sleep = can_sleep(model);
  if (plan.may_sleep) wake_rows(model, state, inputs, plan.has_coarse_space);
  plan.corrects = plan.has_coarse_space && (!plan.may_sleep || state.sleep.moved_by_coarse);
  plan.measures = inputs.measure_residual && model.params.solver.method == Method::kVbd;
  return plan;
}

/// Phases of a step on the host (step_sequence.hpp).
struct HostStep {
  const Exec& exec;
  const Model& model;
  State& state;
  const Inputs& inputs;
  double dt;
  StepPlan plan;
  CalmRows calm = {};
  StepReport report = {};
  Residual residual = {};
  bool is_slow = false;    // the first correction moved no unknown by more than sleep_speed · dt
  bool is_solved = false;  // the first correction was a full step of an operator with stitches

  void add_loads() { lattice::add_loads(model, state, inputs, dt); }
  void move_to_start() { lattice::move_to_start(exec, model, state, inputs, dt); }
  void sweep() { sweep_pbd(exec, model, state, inputs.halo); }
  void sweep(Order order) {
    refresh_springs();
    sweep_vbd(exec, model, state, inputs, dt, order, plan.may_sleep && plan.corrects ? &calm : nullptr);
  }
  /// True if other free bodies bear the forces of the contacts.
  bool has_free_partner() const { return inputs.balances_momentum || inputs.measures_balance; }
  /// A body in contact that nothing fixes moves as a whole, which sweeps do slowly, and touches or not. With
  /// two corrections a step, it bounces at rest.
  bool alternates() const {
    const bool is_free = model.anatomy.free_nodes >= model.anatomy.body_nodes;
    return plan.corrects && is_free && !inputs.contacts.empty() && !inputs.balances_momentum;
  }
  void refresh_springs() {
    if (inputs.springs && inputs.springs->refresh) inputs.springs->refresh(state);
  }
  void correct_between() {
    if (!plan.corrects) return;
    refresh_springs();
    const CoarseStep done = apply_coarse_correction(exec, model, state, inputs, dt);
    is_slow = done.displacement <= model.params.solver.sleep_speed * dt;
    is_solved = has_coupled_points(state) && std::abs(done.step_length - 1) <= kFullStep;
  }
  /// A body that can sleep skips the second correction after a slow first one, and a body with stitches after
  /// a full first one.
  void correct_after() {
    refresh_springs();
    if (plan.corrects && !(plan.may_sleep && is_slow) && !is_solved) {
      apply_coarse_correction(exec, model, state, inputs, dt);
      refresh_springs();
      update_contact_forces();
    }
  }
  /// Forces of contacts where the last correction left them. Contacts between free bodies keep those of the
  /// last sweep: with new ones, two blocks that collide win 1 % of energy.
  void update_contact_forces() {
    if (inputs.contacts.empty() || has_free_partner()) return;
    const CutElementForces cut_elements(model, state);
    if (inputs.points)
      PointContacts{inputs.contacts, *inputs.points, cut_elements.view}.update_forces();
    else
      update_forces(inputs.contacts, cut_elements.nodes);
  }
  void measure_residual_before() {
    if (plan.measures) residual.before = measure_residual(exec, model, state, inputs, dt).rms;
  }
  void measure_residual_after() {
    if (!plan.measures) return;
    const double before = residual.before;
    residual = measure_residual(exec, model, state, inputs, dt);
    residual.before = before;
  }
  /// Velocities; restores the last state if one is not finite.
  void finish() {
    Vec3d unbalanced;
    if (inputs.measures_balance) unbalanced = unbalanced_force(model, state, inputs, dt);
    if (inputs.balances_momentum) balance_momentum(model, state, inputs, dt);
    report = lattice::finish(exec, model, state, dt, inputs.halo);
    report.residual = residual, report.unbalanced = unbalanced;
  }
};

}  // namespace

StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  TURGOR_ASSERT(!inputs.balances_momentum || model.params.solver.method == Method::kVbd,
                "momentum is balanced with the VBD solver");
  check_contacts(model, inputs);
  check_springs(model, inputs);
  HostStep body{exec, model, state, inputs, dt, prepare_step(exec, model, state, inputs, dt)};

  // predictor, sweeps, velocities
  begin_viscous_step(exec, model, state, dt);
  const SolverParams& solver = model.params.solver;
  if (solver.method == Method::kPbd)
    step_pbd(body, solver.sweeps);
  else
    step_vbd(body, model.params.tissue.law == TissueLaw::kSolid, vbd_sweeps(model.params));

  end_viscous_step(exec, model, state, dt, body.report.finite);

  // sleep
  if (body.plan.may_sleep && body.report.finite) {
    put_rows_to_sleep(exec, model, state, dt, body.plan.has_coarse_space);
    count_sleeping_rows(model, state, body.report);
  }
  return body.report;
}

}  // namespace turgor::lattice
