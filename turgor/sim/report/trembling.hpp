// Forces on tools that tremble: few sweeps of a lattice do not converge under a tool.
#pragma once

#include <optional>
#include <string>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Force on a tool that rests, whose reversals follow each other within a few frames.
struct Trembling {
  double from = 0, to = 0;  // time of these samples [s]
  double mean = 0;          // of the force [N]
  double swing = 0;         // half of the mean change between two reversals [N]
};

/// The largest trembling of a tool on a lattice, relative to its mean; empty below 5 %, and for other models.
std::optional<Trembling> force_trembling(const TouchingTool& tool);
/// Warning that the force on a tool trembles; empty if it does not.
std::string trembling_note(const World& world, const TouchingTool& tool);

}  // namespace turgor
