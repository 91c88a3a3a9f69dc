// Frame of a lattice body: loads, tools and solver steps.
#include <algorithm>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/sim/bodies/cloth/cloth_support.hpp"
#include "turgor/sim/bodies/lack_of_memory.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/lattice/touch_lattice.hpp"
#include "turgor/sim/live/exchanges.hpp"
#include "turgor/sim/organs/free_lattice.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Steps a lattice between two times [s], in substeps for fast tools.
lattice::StepReport step_lattice(const Exec& exec, LatticeBody& body, World& world, lattice::Inputs inputs,
                                 const SweptForces& springs, double from, double to) {
  std::vector<TouchingTool>& tools = world.tools;
  SweptContacts swept(body, world, springs);
  if (body.tools.empty()) {
    swept.join(inputs, to - from);
    const lattice::StepReport report = body.state.step(exec, body.model, inputs, to - from);
    swept.finish();
    return report;
  }

  TURGOR_CHECK(to > from, "a frame has a positive length");
  // tools, and the surface where it may be touched
  const Timer timer;
  teleport_tools(body, tools, from);
  const int substeps = substep_count(body, tools, from, to);
  if (substeps > 1 || needs_surface(body)) refresh_surface(exec, body);
  lattice::StepReport report;

  // substeps, so that no tool moves too far
  for (int substep = 1; substep <= substeps && report.finite; substep++) {
    // contacts at the tools' present poses
    set_poses(body, tools, from + (to - from) * substep / substeps);
    const double dt = (to - from) / substeps;
    find_tool_contacts(body, dt, inputs);
    swept.join(inputs, dt);

    // step and forces
    const Real fastest = report.largest_speed;
    lattice::Inputs with_needles = inputs;
    NeedleSprings needles(body, inputs.springs);
    with_needles.springs = needles.input();
    report = body.state.step(exec, body.model, with_needles, dt);
    needles.finish(report.finite);
    swept.finish();
    report.largest_speed = std::max(report.largest_speed, fastest);
    read_tool_forces(body);
  }
  measure_targets(body);
  if (report.finite) note_passed_tools(body, tools, to);
  record_step(body, tools, to, timer.seconds());
  return report;
}

}  // namespace

void step_body(const Exec& exec, LatticeBody& body, World& world, const FrameInput& input,
               FrameReport& report) {
  // projections have no residual forces
  const bool has_forces = body.model.params.solver.method == lattice::Method::kVbd;
  const std::vector<lattice::NodeLoad> loads = node_loads(body);

  // loads, tools, stitches and attachments
  SutureSprings stitches(body, int(&body - world.lattice_bodies.data()), world.sutures);
  SweptSprings attachments(body, world, stitches.input());
  lattice::Inputs inputs{.gravity = body.has_gravity ? world.gravity : Vec3d{},
                         .measure_residual = input.measure_residual && has_forces,
                         .loads = loads,
                         .springs = attachments.input()};
  set_free_motion(world, body, inputs);
  apply_commands(body, input.from, input.to, world.tools);

  // step
  const lattice::StepReport done =
      step_lattice(exec, body, world, inputs, attachments.before(), input.from, input.to);
  if (body.state.take_lack_of_memory()) body.notes.push_back(note_of_lacking_memory(input.from));
  if (done.finite && stitches.input()) stitches.finish(body.model, body.state->motion, input.to);
  if (done.finite && attachments.input()) attachments.finish(body.state->motion);
  record_balance(world, body, done);
  // damping reduces the speed after the positions were updated
  body.last_displacement =
      double(done.largest_speed) / double(speed_scale(body.model.params.solver, input.to - input.from));
  body.row_steps += done.rows, body.row_steps_asleep += done.rows_asleep;
  publish_contacts(body);

  // report
  report.finite = report.finite && done.finite;
  report.largest_speed = std::max(report.largest_speed, double(done.largest_speed));
  report.residual.largest = std::max(report.residual.largest, done.residual.largest);
  report.residual.rms = std::max(report.residual.rms, done.residual.rms);
  report.residual.before = std::max(report.residual.before, done.residual.before);
}

std::uint64_t state_hash(const LatticeBody& body, std::uint64_t seed) {
  const std::uint64_t one = lattice::state_hash(body.model, body.state);
  return hash_bytes(&one, sizeof one, seed);
}

}  // namespace turgor
