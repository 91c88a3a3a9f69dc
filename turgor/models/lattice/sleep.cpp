#include "turgor/models/lattice/sleep.hpp"

#include <algorithm>

namespace turgor::lattice {

namespace {

bool is_storage_row(const State& state, int row) {
  return row >= 0 && std::size_t(row) < state.sleep.still.size();
}

void wake_around(const Model& model, State& state, int slot, int reach) {
  for_each_row_beside(model.lattice, row_of(model, slot), reach, [&](int row) {
    if (is_storage_row(state, row)) state.sleep.still[std::size_t(row)] = 0;
  });
}

/// Around the cells that have been cut since the last step.
void wake_cuts(const Model& model, State& state) {
  for (std::size_t n = state.sleep.cuts; n < state.cut_edges.size(); n++)
    wake_around(model, state, state.cut_edges[n].slot, 2);
  state.sleep.cuts = state.cut_edges.size();
}

bool has_moved_near(const Model& model, const State& state, int row) {
  bool any = false;
  for_each_row_beside(model.lattice, row, 1, [&](int beside) {
    any |= is_storage_row(state, beside) && state.sleep.moved[std::size_t(beside)];
  });
  return any;
}

/// At rest where it is.
void stop_row(const Model& model, State& state, int row) {
  for (int half_row = 2 * row; half_row < 2 * row + 2; half_row++)
    for (const Run run : model.moving.of_half_row(half_row))
      for (auto s = std::size_t(run.begin); s < std::size_t(run.begin + run.count); s++) {
        state.u_before.set(s, state.u[s]);
        state.v.set(s, {});
      }
}

}  // namespace

void wake_rows(const Model& model, State& state, const Inputs& inputs) {
  Sleep& sleep = state.sleep;
  const std::size_t rows = state.row_cut.size();
  if (sleep.still.size() != rows || !(sleep.gravity == inputs.gravity)) sleep.still.assign(rows, 0);
  sleep.gravity = inputs.gravity;
  wake_cuts(model, state);
  for (const NodeLoad& load : inputs.loads) wake_around(model, state, load.slot, 1);
  for (const NodeContact& contact : inputs.contacts) wake_around(model, state, contact.slot, 1);
  sleep.awake.resize(rows), sleep.moved.assign(rows, 0);
  for (std::size_t row = 0; row < rows; row++) sleep.awake[row] = sleep.still[row] < kStillSteps;
}

void spread_motion(const Model& model, State& state) {
  Sleep& sleep = state.sleep;
  for (int row = 0; row < int(sleep.moved.size()); row++)
    if (sleep.moved[std::size_t(row)])
      for_each_row_beside(model.lattice, row, 1, [&](int beside) { sleep.awake[std::size_t(beside)] = 1; });
}

void lay_down_rows(const Exec& exec, const Model& model, State& state) {
  const int rows_of_layer = model.lattice.size.y + 2;
  parallel_for(exec, std::size_t(model.lattice.size.z), [&](std::size_t k) {
    for (int row = int(k + 1) * rows_of_layer; row < int(k + 2) * rows_of_layer; row++) {
      if (!state.sleep.awake[std::size_t(row)]) continue;
      std::uint8_t& still = state.sleep.still[std::size_t(row)];
      still = has_moved_near(model, state, row) ? 0 : std::uint8_t(std::min(still + 1, kStillSteps));
      if (still == kStillSteps) stop_row(model, state, row);
    }
  });
}

void count_sleepers(const Model& model, const State& state, StepReport& report) {
  for (std::size_t row = 0; row < state.sleep.awake.size(); row++) {
    if (model.moving.row_begin[2 * row] == model.moving.row_begin[2 * row + 2]) continue;
    report.rows++;
    report.rows_asleep += !state.sleep.awake[row];
  }
}

}  // namespace turgor::lattice
