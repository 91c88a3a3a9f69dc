// One batch of the linear system: sixteen rows at once.
#pragma once

#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {

/// force + s Σ J_ij a_j, the right-hand side that Jacobi's method sees, of the vertices from i on.
inline Lanes3 with_neighbours(const Model& model, const State& state, const Vectors& a, std::size_t i,
                              Lanes3 sum) {
  const System& system = state.system;
  const Rows& rows = model.rows;
  const Lanes3 x = load(state.x, i);
  const std::size_t batch = i / std::size_t(kLanes);
  for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
    const Lanes3 d = load_neighbours(rows, state.x, s) - x, other = load_neighbours(rows, a, s);
    const auto entry = std::size_t(s) * std::size_t(kLanes);
    sum = sum + d * (load_lanes(&system.along[entry]) * dot(d, other)) +
          other * load_lanes(&system.across[entry]);
  }
  return sum;
}

inline LanesMatrix inverse_diagonal(const System& system, std::size_t i) {
  return {load(system.inverse[0], i), load(system.inverse[1], i)};
}

}  // namespace turgor::cloth
