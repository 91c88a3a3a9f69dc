#include "turgor/sim/live/exchanges.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/haptics/safety.hpp"

namespace turgor {

namespace {

/// Records a command. A displacement that a hand cannot make in a tick is a teleport by a mouse or a program.
/// A teleport discards the tool's contact.
void record_command(LocalExchange& exchange, const contact::ToolCommand& now) {
  NumberedCommand& last = exchange.latest_tick;
  const double longest = haptics::SafetyParams().jump;
  if (norm(now.pose.position - last.command.pose.position) > longest) {
    last.teleports++, last.teleported_to = now.pose;
    contact::end_contact(exchange.touch);
  }
  last.command = now, last.number++;
  last.texture = exchange.touch.texture;
}

/// Takes the newest plane. Ignores planes from before the latest teleport.
void receive_contact(LocalExchange& exchange) {
  const contact::LocalContact& plane = exchange.plane.read();
  if (plane.teleports == exchange.latest_tick.teleports)
    contact::update_contact(exchange.touch, plane), exchange.age = 0;
}

}  // namespace

void begin_haptics(FrameTouchedBody& body, const std::vector<TouchingTool>& tools) {
  body.haptic = std::vector<LocalExchange>(body.tool_indices.size());
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    LocalExchange& exchange = body.haptic[t];
    exchange.before = command_at(tools[std::size_t(body.tool_indices[t])], 0);
    exchange.latest_tick.command = exchange.before;
    exchange.touch.map = body.texture.map;
    if (!body.textures.empty()) exchange.touch.texture = body.textures[t];
    exchange.touch.texture.is_touching = false;
    exchange.command.write(exchange.latest_tick);
  }
}

void tick_haptics(FrameTouchedBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  TURGOR_CHECK(commands.size() == body.haptic.size() && readings.size() == commands.size(),
               "one command and one reading a tool");
  for (std::size_t t = 0; t < commands.size(); t++) {
    LocalExchange& exchange = body.haptic[t];
    record_command(exchange, commands[t]);
    exchange.command.write(exchange.latest_tick);
    exchange.age += dt;
    if (exchange.plane.has_news()) receive_contact(exchange);
    contact::tick_local_touch(exchange.touch, commands[t], dt, readings[t]);
    readings[t].age = exchange.age;
  }
}

void log_tick(const FrameTouchedBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool) {
  TURGOR_CHECK(is_index(t, body.haptic.size()), "every tool has an exchange");
  ForceSample logged = sample;
  if (const contact::LocalNeedle& needle = body.haptic[t].touch.contact.needle; needle.is_needle) {
    logged.needle = needle.reading;
    tool.needle_work = needle.work, tool.punctures = needle.punctures, tool.entry_force = needle.entry_force;
  }
  tool.samples.append(logged);
}

void queue_frame_output(FrameTouchedBody& body) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++)
    body.haptic[t].replay_queue.push(body.haptic[t].plane);
}

void replay_frame_output(FrameTouchedBody& body, std::size_t t, TickInputs inputs_used) {
  TURGOR_CHECK(is_index(t, body.haptic.size()), "every tool has an exchange");
  LocalExchange& exchange = body.haptic[t];
  exchange.replay_queue.release(inputs_used.frame, exchange.plane);
}

void apply_commands(FrameTouchedBody& body, double from, double to, std::vector<TouchingTool>& tools) {
  constexpr int kRows = 16;
  TURGOR_CHECK(body.haptic.empty() || body.haptic.size() == body.tool_indices.size(),
               "every tool has an exchange");
  TURGOR_CHECK(to >= from, "frames do not run backwards");
  for (std::size_t t = 0; t < body.haptic.size(); t++) {
    LocalExchange& exchange = body.haptic[t];

    // newest command; a teleport restarts the motion
    const NumberedCommand newest = exchange.command.read();
    exchange.was_teleported = newest.teleports != exchange.teleports;
    if (exchange.was_teleported) exchange.before.pose = newest.teleported_to, exchange.history = {};
    const contact::ToolCommand before = exchange.before, now = newest.command;

    // linear motion over the frame
    std::vector<HandRow>& hand = tools[std::size_t(body.tool_indices[t])].hand;
    hand.resize(kRows + 1);
    for (int row = 0; row <= kRows; row++) {
      const double s = double(row) / kRows;
      hand[std::size_t(row)] = {from + (to - from) * s, now};
      hand[std::size_t(row)].command.pose.position = before.pose.position * (1 - s) + now.pose.position * s;
    }

    // start of the next frame
    exchange.before = now, exchange.ticks = newest.number, exchange.teleports = newest.teleports;
    body.textures.resize(body.haptic.size());
    body.textures[t] = newest.texture;
  }
}

void publish_contact(FrameTouchedBody& body, std::size_t t, contact::LocalContact plane) {
  TURGOR_CHECK(is_index(t, body.haptic.size()), "every tool has an exchange");
  LocalExchange& exchange = body.haptic[t];
  plane.number = ++exchange.plane_count, plane.teleports = exchange.teleports;
  plane.waves = body.texture.waves;
  exchange.plane.write(plane);
}

}  // namespace turgor
