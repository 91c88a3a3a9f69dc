// Exchange of an sfem body between haptic thread and frames; sim/live/exchanges.hpp documents the functions.
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

void begin_haptics(SfemBody& body, const std::vector<TouchingTool>& /*tools*/) {
  body.haptic = std::make_unique<SfemHaptics>();
  body.built_patches = 0;
  contact::prepare(body.touch, body.haptic->exchange);
}

void tick_haptics(SfemBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  TURGOR_ASSERT(body.haptic, "a haptic thread is prepared before its ticks");
  contact::tick_with_exchange(body.touch, body.haptic->exchange, commands, dt, readings);
}

TickInputs tick_inputs(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.touch.motion_number), std::int32_t(body.touch.patch_number)};
}

FrameInputs frame_inputs(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.now.ticks), body.built_patches};
}

void end_haptics(SfemBody& body) {
  body.haptic.reset();
  body.patch_is_ready.reset();
}

void queue_frame_output(SfemBody& body) {
  TURGOR_ASSERT(body.haptic, "a replay has a haptic exchange");
  body.haptic->motions.push(body.haptic->exchange.motion);
  body.haptic->patches.push(body.haptic->exchange.patches);
}

void replay_frame_output(SfemBody& body, std::size_t /*t*/, TickInputs inputs_used) {
  TURGOR_ASSERT(body.haptic, "a replay has a haptic exchange");
  body.haptic->motions.release(inputs_used.frame, body.haptic->exchange.motion);
  body.haptic->patches.release(inputs_used.patch, body.haptic->exchange.patches);
}

void set_friction(SfemBody& body, std::size_t t, double friction) {
  if (body.friction.empty())
    for (const contact::Tool& tool : body.touch.tools) body.friction.push_back(tool.friction);
  TURGOR_CHECK(is_index(t, body.friction.size()), "every tool has a friction");
  body.friction[t] = friction;
}

void expect_patch(SfemBody& body, bool is_ready) { body.patch_is_ready = is_ready; }

}  // namespace turgor
