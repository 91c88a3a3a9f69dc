#include "turgor/sim/live/exchanges.hpp"

namespace turgor {

void begin_felt(FrameTouchedBody& body, const std::vector<TouchingTool>& tools) {
  body.felt = std::vector<LocalExchange>(body.tool_indices.size());
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    LocalExchange& exchange = body.felt[t];
    exchange.before = command_at(tools[std::size_t(body.tool_indices[t])], 0);
    exchange.command.write({exchange.before, 0});
  }
}

void tick_felt(FrameTouchedBody& body, std::span<const contact::ToolCommand> commands, double dt,
               std::span<contact::ToolReading> readings) {
  for (std::size_t t = 0; t < commands.size(); t++) {
    LocalExchange& exchange = body.felt[t];
    exchange.command.write({commands[t], ++exchange.done});
    exchange.age += dt;
    if (exchange.plane.has_news()) contact::take(exchange.touch, exchange.plane.read()), exchange.age = 0;
    contact::tick(exchange.touch, commands[t], dt, readings[t]);
    readings[t].age = exchange.age;
  }
}

void keep_frame(FrameTouchedBody& body) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) body.felt[t].awaiting.keep(body.felt[t].plane);
}

void give_frame(FrameTouchedBody& body, std::size_t t, TickKnew knew) {
  LocalExchange& exchange = body.felt[t];
  exchange.awaiting.give(knew.frame, exchange.plane);
}

void take_commands(FrameTouchedBody& body, double from, double to, std::vector<TouchingTool>& tools) {
  constexpr int kRows = 16;
  for (std::size_t t = 0; t < body.felt.size(); t++) {
    LocalExchange& exchange = body.felt[t];
    const NumberedCommand newest = exchange.command.read();
    const contact::ToolCommand before = exchange.before, now = newest.command;
    std::vector<HandRow>& hand = tools[std::size_t(body.tool_indices[t])].hand;
    hand.resize(kRows + 1);
    for (int row = 0; row <= kRows; row++) {
      const double part = double(row) / kRows;
      hand[std::size_t(row)] = {from + (to - from) * part, now};
      hand[std::size_t(row)].command.pose.position =
          before.pose.position * (1 - part) + now.pose.position * part;
    }
    exchange.before = now, exchange.ticks = newest.number;
  }
}

void leave_plane(FrameTouchedBody& body, std::size_t t, contact::LocalContact plane) {
  LocalExchange& exchange = body.felt[t];
  plane.number = ++exchange.planes;
  exchange.plane.write(plane);
}

}  // namespace turgor
