// One step of the lattice model: coarse space, sleep, predictor, sweeps with coarse corrections, velocities.
#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

void check_contacts(const Model& model, std::span<const NodeContact> contacts) {
  TURGOR_ASSERT(contacts.empty() || model.params.solver.method == Method::kVbd,
                "contacts need the VBD solver");
  for (std::size_t c = 0; c < contacts.size(); c++) {
    const auto slot = std::size_t(contacts[c].slot);
    TURGOR_ASSERT(c == 0 || contacts[c - 1].slot <= contacts[c].slot, "the slots of contacts ascend");
    TURGOR_ASSERT(slot < model.inverse_mass.size() && model.inverse_mass[slot] > 0,
                  "contacts act on free nodes");
  }
}

struct StepPlan {
  bool has_coarse_space = false;
  bool may_sleep = false;
  bool corrects = false;  // applies coarse corrections
  bool measures = false;  // measures the residual
};

/// Prepares the coarse space, wakes rows, and decides on coarse corrections and measurements.
StepPlan prepare_step(const Model& model, State& state, const Inputs& inputs, double dt) {
  StepPlan plan;
  plan.has_coarse_space = prepare_coarse_space(model, state, inputs, dt);
  plan.may_sleep = can_sleep(model);
  if (plan.may_sleep) wake_rows(model, state, inputs, plan.has_coarse_space);
  plan.corrects = plan.has_coarse_space && (!plan.may_sleep || state.sleep.moved_by_coarse);
  plan.measures = inputs.measure_residual && model.params.solver.method == Method::kVbd;
  return plan;
}

void run_pbd_sweeps(const Exec& exec, const Model& model, State& state, const Inputs& inputs) {
  for (int sweep = 0; sweep < model.params.solver.sweeps; sweep++) sweep_pbd(exec, model, state, inputs.halo);
}

/// VBD sweeps with a coarse correction before the first backward sweep, and another one after the last sweep.
/// If the body can sleep, the second correction is skipped when the first moved no unknown by more than
/// sleep_speed · dt.
void run_vbd_sweeps(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt,
                    const StepPlan& plan) {
  const SolverParams& solver = model.params.solver;
  const bool solid = model.params.tissue.law == TissueLaw::kSolid;
  bool is_slow = false;
  for (int sweep = 0; sweep < solver.sweeps; sweep++) {
    if (plan.corrects && is_first_backward_sweep(solid, sweep, solver.sweeps))
      is_slow = apply_coarse_correction(exec, model, state, inputs, dt) <= solver.sleep_speed * dt;
    sweep_vbd(exec, model, state, inputs, dt, sweep_order(solid, sweep, solver.sweeps));
  }
  if (plan.corrects && !(plan.may_sleep && is_slow)) apply_coarse_correction(exec, model, state, inputs, dt);
}

}  // namespace

StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  check_contacts(model, inputs.contacts);
  const StepPlan plan = prepare_step(model, state, inputs, dt);

  // predictor
  predict(exec, model, state, inputs, dt);
  const double before = plan.measures ? measure_residual(exec, model, state, inputs, dt).rms : 0;

  // sweeps
  if (model.params.solver.method == Method::kPbd)
    run_pbd_sweeps(exec, model, state, inputs);
  else
    run_vbd_sweeps(exec, model, state, inputs, dt, plan);

  // residual
  Residual residual;
  if (plan.measures) residual = measure_residual(exec, model, state, inputs, dt);
  residual.before = before;

  // velocities; restores the last state if one is not finite
  StepReport report = finish(exec, model, state, dt, inputs.halo);
  report.residual = residual;

  // sleep
  if (plan.may_sleep && report.finite) {
    put_rows_to_sleep(exec, model, state, dt, plan.has_coarse_space);
    count_sleeping_rows(model, state, report);
  }
  return report;
}

}  // namespace turgor::lattice
