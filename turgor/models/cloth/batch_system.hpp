// One batch of the linear system: sixteen rows at once.
#pragma once

#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {

/// What Jacobi's method sees on its right-hand side, of the vertices from i on: force + s Σ J_ij a_j, and
/// what the diagonal has beyond W's times a_i.
inline Lanes3 with_neighbours(const Model& model, const State& state, const Vectors& a, std::size_t i,
                              Lanes3 sum) {
  const System& system = state.system;
  const Rows &rows = model.rows, &far = model.far_rows;
  const Lanes3 x = load(state.x, i);
  const std::size_t batch = i / std::size_t(kLanes);
  for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
    const Lanes3 d = load_neighbours(rows, state.x, s) - x, other = load_neighbours(rows, a, s);
    const auto entry = std::size_t(s) * std::size_t(kLanes);
    sum = sum + d * (load_lanes(&system.along[entry]) * dot(d, other)) +
          other * load_lanes(&system.across[entry]);
  }
  if (far.slot_begin.empty()) return sum;
  const Lanes is_free = load_lanes(&state.free_mass[i]) > 0 ? all_lanes(1) : all_lanes(0);
  Lanes3 bend = load(a, i) * load_lanes(&model.spare[i]);
  for (int s = far.slot_begin[batch]; s < far.slot_begin[batch + 1]; s++)
    bend = bend + load_neighbours(far, a, s) * load_lanes(&far.bend[std::size_t(s) * std::size_t(kLanes)]);
  return sum + bend * (is_free * system.square);
}

inline LanesMatrix inverse_diagonal(const System& system, std::size_t i) {
  return {load(system.inverse[0], i), load(system.inverse[1], i)};
}

}  // namespace turgor::cloth
