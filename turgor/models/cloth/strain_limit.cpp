#include "turgor/models/cloth/strain_limit.hpp"

namespace turgor::cloth {

namespace {

/// At the vertices from i on; a sheet's rows do not keep them.
Lanes rest_lengths(const Model& model, std::size_t i, int slot) {
  const Rows& rows = model.rows;
  if (!rows.rest.empty()) return load_lanes(&rows.rest[std::size_t(slot) * std::size_t(kLanes)]);
  const Lanes3 d = load_neighbours(rows, model.x_rest, slot) - load(model.x_rest, i);
  return square_root(dot(d, d));
}

}  // namespace

void limit_strain(const Exec& exec, const Model& model, State& state, double dt) {
  constexpr int kPasses = 12;
  const Real limit = Real(1 + model.params.solver.strain_limit), h = Real(dt);
  const Rows& rows = model.rows;
  Vectors& next = state.system.before;
  for (int pass = 0; pass < kPasses; pass++) {
    parallel_for(
        exec, batch_count(rows),
        [&](std::size_t batch) {
          const std::size_t i = batch * std::size_t(kLanes);
          const Lanes3 x = load(state.x, i), v = load(state.v, i);
          const Lanes mass = load_lanes(&state.free_mass[i]);
          const Lanes zero = all_lanes(0), one = all_lanes(1);
          Lanes3 change{};
          Lanes springs = zero;
          for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
            const Lanes3 u = load_neighbours(rows, state.v, s) - v;
            const Lanes3 d = load_neighbours(rows, state.x, s) - x + u * all_lanes(h);
            const auto entry = std::size_t(s) * std::size_t(kLanes);
            const Lanes length = square_root(larger(dot(d, d), all_lanes(1e-20f)));
            const Lanes excess = larger(1 - limit * rest_lengths(model, i, s) / length, zero);
            const Lanes counts = load_lanes(&rows.stiffness[entry]) > 0 ? one : zero;
            const Lanes is_long = excess > 0 ? counts : zero;
            const Lanes other = load_neighbours(rows, state.free_mass, s);
            const Lanes part = other > 0 ? all_lanes(0.5f) : one;  // a held neighbour does nothing
            change = change + d * (is_long * excess * part / h);
            springs = springs + is_long;
          }
          const Lanes share = mass > 0 ? one / larger(springs, one) : zero;
          store(next, i, v + change * share);
        },
        16);
    std::swap(state.v, next);
  }
}

}  // namespace turgor::cloth
