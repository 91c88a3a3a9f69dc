// A body of sfem between a haptic thread and the frames: sim/live/exchanges.hpp says what each name does.
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

void begin_haptics(SfemBody& body, const std::vector<TouchingTool>& /*tools*/) {
  body.haptic = std::make_unique<SfemHaptics>();
  body.built_patches = 0;
  contact::prepare(body.touch, body.haptic->exchange);
}

void tick_haptics(SfemBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  contact::tick(body.touch, body.haptic->exchange, commands, dt, readings);
}

TickInputs tick_inputs(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.touch.frame), std::int32_t(body.touch.taken)};
}

FrameInputs frame_inputs(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.now.ticks), body.built_patches};
}

void end_haptics(SfemBody& body) {
  body.haptic.reset();
  body.patch_is_ready.reset();
}

void keep_frame(SfemBody& body) {
  body.haptic->motions.keep(body.haptic->exchange.motion);
  body.haptic->patches.keep(body.haptic->exchange.patches);
}

void give_frame(SfemBody& body, std::size_t /*t*/, TickInputs inputs_used) {
  body.haptic->motions.give(inputs_used.frame, body.haptic->exchange.motion);
  body.haptic->patches.give(inputs_used.patch, body.haptic->exchange.patches);
}

void set_friction(SfemBody& body, std::size_t t, double friction) {
  if (body.friction.empty())
    for (const contact::Tool& tool : body.touch.tools) body.friction.push_back(tool.friction);
  body.friction[t] = friction;
}

void expect_patch(SfemBody& body, bool is_ready) { body.patch_is_ready = is_ready; }

}  // namespace turgor
