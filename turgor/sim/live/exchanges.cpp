#include "turgor/sim/live/exchanges.hpp"

namespace turgor {

void take_commands(std::span<const int> tool_indices, Exchanges& felt, double from, double to,
                   std::vector<TouchingTool>& tools) {
  constexpr int kRows = 16;
  for (const int t : tool_indices) {
    LocalExchange& exchange = *felt.local[std::size_t(t)];
    const contact::ToolCommand before = exchange.before, now = exchange.command.read();
    std::vector<HandRow>& hand = tools[std::size_t(t)].hand;
    hand.resize(kRows + 1);
    for (int row = 0; row <= kRows; row++) {
      const double part = double(row) / kRows;
      hand[std::size_t(row)] = {from + (to - from) * part, now};
      hand[std::size_t(row)].command.pose.position =
          before.pose.position * (1 - part) + now.pose.position * part;
    }
    exchange.before = now;
  }
}

}  // namespace turgor
