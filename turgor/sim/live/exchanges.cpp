#include "turgor/sim/live/exchanges.hpp"

#include "turgor/haptics/safety.hpp"

namespace turgor {

namespace {

/// A tick later. What is farther than a hand moves in a tick is no way: a mouse, or a program, put the tool
/// there, where nothing is known yet.
void extrapolate(LocalExchange& exchange, const contact::ToolCommand& now) {
  NumberedCommand& last = exchange.latest_tick;
  const double longest = haptics::SafetyParams().jump;
  if (norm(now.pose.position - last.command.pose.position) > longest) {
    last.teleports++, last.put = now.pose;
    exchange.touch = {.params = exchange.touch.params};
  }
  last.command = now, last.number++;
}

/// Not one of where the tool was before it was put elsewhere.
void take_plane(LocalExchange& exchange) {
  const contact::LocalContact& plane = exchange.plane.read();
  if (plane.teleports == exchange.latest_tick.teleports)
    contact::take(exchange.touch, plane), exchange.age = 0;
}

}  // namespace

void begin_haptics(FrameTouchedBody& body, const std::vector<TouchingTool>& tools) {
  body.haptic = std::vector<LocalExchange>(body.tool_indices.size());
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    LocalExchange& exchange = body.haptic[t];
    exchange.before = command_at(tools[std::size_t(body.tool_indices[t])], 0);
    exchange.latest_tick.command = exchange.before;
    exchange.command.write(exchange.latest_tick);
  }
}

void tick_haptics(FrameTouchedBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  for (std::size_t t = 0; t < commands.size(); t++) {
    LocalExchange& exchange = body.haptic[t];
    extrapolate(exchange, commands[t]);
    exchange.command.write(exchange.latest_tick);
    exchange.age += dt;
    if (exchange.plane.has_news()) take_plane(exchange);
    contact::tick(exchange.touch, commands[t], dt, readings[t]);
    readings[t].age = exchange.age;
  }
}

void keep_frame(FrameTouchedBody& body) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++)
    body.haptic[t].awaiting.keep(body.haptic[t].plane);
}

void give_frame(FrameTouchedBody& body, std::size_t t, TickInputs inputs_used) {
  LocalExchange& exchange = body.haptic[t];
  exchange.awaiting.give(inputs_used.frame, exchange.plane);
}

void take_commands(FrameTouchedBody& body, double from, double to, std::vector<TouchingTool>& tools) {
  constexpr int kRows = 16;
  for (std::size_t t = 0; t < body.haptic.size(); t++) {
    LocalExchange& exchange = body.haptic[t];
    const NumberedCommand newest = exchange.command.read();
    exchange.was_teleported = newest.teleports != exchange.teleports;
    if (exchange.was_teleported) exchange.before.pose = newest.put, exchange.memory = {};
    const contact::ToolCommand before = exchange.before, now = newest.command;
    std::vector<HandRow>& hand = tools[std::size_t(body.tool_indices[t])].hand;
    hand.resize(kRows + 1);
    for (int row = 0; row <= kRows; row++) {
      const double part = double(row) / kRows;
      hand[std::size_t(row)] = {from + (to - from) * part, now};
      hand[std::size_t(row)].command.pose.position =
          before.pose.position * (1 - part) + now.pose.position * part;
    }
    exchange.before = now, exchange.ticks = newest.number, exchange.teleports = newest.teleports;
  }
}

void leave_plane(FrameTouchedBody& body, std::size_t t, contact::LocalContact plane) {
  LocalExchange& exchange = body.haptic[t];
  plane.number = ++exchange.planes, plane.teleports = exchange.teleports;
  exchange.plane.write(plane);
}

}  // namespace turgor
