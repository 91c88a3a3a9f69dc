// A body of sfem between a haptic thread and the frames: sim/live/exchanges.hpp says what each name does.
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

void begin_felt(SfemBody& body, const std::vector<TouchingTool>& /*tools*/) {
  body.felt = std::make_unique<SfemFelt>();
  body.built_patches = 0;
  contact::prepare(body.touch, body.felt->exchange);
}

void tick_felt(SfemBody& body, std::span<const contact::ToolCommand> commands, double dt,
               std::span<contact::ToolReading> readings) {
  contact::tick(body.touch, body.felt->exchange, commands, dt, readings);
}

TickKnew tick_knew(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.touch.frame), std::int32_t(body.touch.taken)};
}

FrameKnew frame_knew(const SfemBody& body, std::size_t /*t*/) {
  return {std::int32_t(body.now.ticks), body.built_patches};
}

void end_felt(SfemBody& body) {
  body.felt.reset();
  body.patch_is_ready.reset();
}

void keep_frame(SfemBody& body) {
  body.felt->motions.keep(body.felt->exchange.motion);
  body.felt->patches.keep(body.felt->exchange.patches);
}

void give_frame(SfemBody& body, std::size_t /*t*/, TickKnew knew) {
  body.felt->motions.give(knew.frame, body.felt->exchange.motion);
  body.felt->patches.give(knew.patch, body.felt->exchange.patches);
}

void set_friction(SfemBody& body, std::size_t t, double friction) {
  if (body.friction.empty())
    for (const contact::Tool& tool : body.touch.tools) body.friction.push_back(tool.friction);
  body.friction[t] = friction;
}

void expect_patch(SfemBody& body, bool is_ready) { body.patch_is_ready = is_ready; }

}  // namespace turgor
