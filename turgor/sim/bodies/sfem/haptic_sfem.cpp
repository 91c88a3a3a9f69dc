// Exchange of an sfem body between haptic thread and frames; sim/live/exchanges.hpp documents the functions.
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

void begin_haptics(SfemBody& body, const std::vector<TouchingTool>& /*tools*/) {
  body.haptic = std::make_unique<SfemHaptics>();
  body.built_patches = 0;
  if (!body.law && !body.needles.inner) contact::reserve_viscosity(body.touch);
  contact::prepare(body.touch, body.haptic->exchange);
}

void tick_haptics(SfemBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  TURGOR_ASSERT(body.haptic, "a haptic thread is prepared before its ticks");
  contact::tick_with_exchange(body.touch, body.haptic->exchange, commands, dt, readings);
}

TickInputs tick_inputs(const SfemBody& body, std::size_t /*t*/) {
  const bool is_solved = body.haptic && body.haptic->exchange.is_solved;
  return {.frame = std::int32_t(body.touch.motion_number),
          .patch = std::int32_t(body.touch.patch_number),
          .solution = is_solved ? std::int32_t(body.touch.solution_tick) : -1};
}

FrameInputs frame_inputs(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.now.ticks), body.built_patches};
}

void end_haptics(SfemBody& body) {
  if (body.haptic && body.haptic->solver) {
    body.haptic->solver->stop();
    collect_solutions(body);
    // later solutions begin at the patch in use
    retain_patch(body.patches, body.touch.patch);
    body.law_forces.clear(), body.law_displacement.clear();
    if (body.touch.patch_number != long(body.rebuilds.size())) body.nonlinear.reset();
  }
  body.haptic.reset();
  body.patch_is_ready.reset();
}

Status begin_solutions(SfemBody& body, bool is_replay) {
  if (!body.law || body.tool_indices.empty()) return Done{};
  TURGOR_ASSERT(body.haptic, "solutions begin after the haptic exchange is prepared");
  restore_nonlinear(body, *body.touch.patch);
  body.touch.stiffening = body.law->stiffening;
  SfemHaptics& haptic = *body.haptic;
  haptic.solver = std::make_unique<LawSolver>();
  haptic.solver->add({body.touch.patch, *body.nonlinear, body.touch.patch_number});
  body.touch.solution_tick = 0;
  // without a thread, frames solve the patch
  if (const Status started = is_replay ? Status(Done{}) : haptic.solver->start(haptic.exchange); !started) {
    haptic.solver.reset();
    return started;
  }
  haptic.exchange.is_solved = true;
  return Done{};
}

void collect_solutions(SfemBody& body) {
  if (!body.haptic || !body.haptic->solver) return;
  const LawProgress progress = body.haptic->solver->take_progress();
  add_solutions(body.law_summary, progress.sum);
  if (progress.failed == 0) return;
  reject_patch(body, Error{progress.failure});
  body.rejected_patches += progress.failed - 1;
}

namespace {

/// Solves the patch as the solver did before this tick, which used the solution for the forces of `tick`.
void replay_solution(SfemBody& body, long tick) {
  SfemHaptics& haptic = *body.haptic;
  if (!haptic.solver) return;
  if (haptic.exchange.forces.has_news()) haptic.forces.push(haptic.exchange.forces.read());
  if (tick <= 0 || tick == haptic.replayed) return;
  haptic.replayed = tick;
  const contact::LawForces* forces = haptic.forces.after(tick);
  if (forces == nullptr) return;  // a damaged recording: the hash will differ
  std::optional<contact::PatchSolution> solution = haptic.solver->solve(*forces);
  if (!solution) return;
  solution->tick = tick;
  haptic.exchange.solutions.write(*solution);
}

}  // namespace

void queue_frame_output(SfemBody& body) {
  TURGOR_ASSERT(body.haptic, "a replay has a haptic exchange");
  body.haptic->motions.push(body.haptic->exchange.motion);
  body.haptic->patches.push(body.haptic->exchange.patches);
}

void replay_frame_output(SfemBody& body, std::size_t /*t*/, TickInputs inputs_used) {
  TURGOR_ASSERT(body.haptic, "a replay has a haptic exchange");
  body.haptic->motions.release(inputs_used.frame, body.haptic->exchange.motion);
  body.haptic->patches.release(inputs_used.patch, body.haptic->exchange.patches);
  replay_solution(body, inputs_used.solution);
}

void set_friction(SfemBody& body, std::size_t t, double friction) {
  if (body.friction.empty())
    for (const contact::Tool& tool : body.touch.tools) body.friction.push_back(tool.friction);
  TURGOR_CHECK(is_index(t, body.friction.size()), "every tool has a friction");
  body.friction[t] = friction;
}

void expect_patch(SfemBody& body, bool is_ready) { body.patch_is_ready = is_ready; }

}  // namespace turgor
