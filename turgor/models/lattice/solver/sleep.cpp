#include "turgor/models/lattice/solver/sleep.hpp"

#include <algorithm>

namespace turgor::lattice {

namespace {

bool is_storage_row(const State& state, int row) {
  return row >= 0 && std::size_t(row) < state.sleep.still.size();
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

/// Calls visit(slot) for what can move in a row.
template <class Visit>
void for_each_slot(const Model& model, int row, const Visit& visit) {
  for (const int half_row : {2 * row, 2 * row + 1})
    for (const Run run : model.moving.of_half_row(half_row))
      for (int s = run.begin; s < run.begin + run.count; s++) visit(std::size_t(s));
}

/// At rest where it is.
void stop_row(const Model& model, State& state, int row) {
  for_each_slot(model, row, [&](std::size_t s) {
    state.u_before.set(s, state.u[s]);
    state.v.set(s, {});
  });
}

/// Has the smooth part of the motion taken it further than a sleeper goes?
bool is_carried_further(const Model& model, const State& state, int row, double dt) {
  const Real way = Real(model.params.solver.sleep * dt);
  bool any = false;
  for_each_slot(model, row, [&](std::size_t s) {
    const Vec3 d = state.u[s] - state.u_before[s];
    any |= !(dot(d, d) <= way * way);
  });
  return any;
}

/// One step more of sleep.
void grow_old(std::uint8_t& still) {
  constexpr std::uint8_t kOldest = 255, kLastLook = 128;
  still = still == kOldest ? kLastLook : std::uint8_t(still + 1);
}

/// Those that fall asleep in one step are not looked at in one step.
std::uint8_t first_of_sleep(int row) { return std::uint8_t(kStillSteps + row % kStillSteps); }

/// As the CT shows it, and nothing pulls at it: that is a place of rest, tense skin or not (measure_pull).
bool is_untouched(const State& state, const Inputs& inputs) {
  const auto is_nil = [](const VecField& field) {
    const auto all = [](const aligned_vector<Real>& axis) {
      return std::all_of(axis.begin(), axis.end(), [](Real a) { return a == 0; });
    };
    return all(field.x) && all(field.y) && all(field.z);
  };
  return cut_version(state) == 0 && inputs.gravity == Vec3d{} && is_nil(state.u) && is_nil(state.v);
}

/// Who sleeps when nobody has looked yet.
void begin_sleep(State& state, const Inputs& inputs) {
  Sleep& sleep = state.sleep;
  sleep.still.assign(state.row_cut.size(), 0), sleep.coarse_still = 0;
  if (!is_untouched(state, inputs)) return;
  for (std::size_t row = 0; row < sleep.still.size(); row++) sleep.still[row] = first_of_sleep(int(row));
}

}  // namespace

void wake_around(const Model& model, State& state, int slot, int reach) {
  for_each_row_beside(model.lattice, row_of(model, slot), reach, [&](int row) {
    if (is_storage_row(state, row)) state.sleep.still[std::size_t(row)] = 0;
  });
}

void wake_rows(const Model& model, State& state, const Inputs& inputs, bool coarse) {
  Sleep& sleep = state.sleep;
  const std::size_t rows = state.row_cut.size();
  if (sleep.still.size() != rows || !(sleep.gravity == inputs.gravity)) begin_sleep(state, inputs);
  sleep.gravity = inputs.gravity;
  if (!coarse || sleep.cuts != state.cut_edges.size() || !inputs.loads.empty()) sleep.coarse_still = 0;
  wake_cuts(model, state);
  for (const NodeLoad& load : inputs.loads) wake_around(model, state, load.slot, 1);
  for (const NodeContact& contact : inputs.contacts) wake_around(model, state, contact.slot, 1);
  sleep.awake.resize(rows), sleep.moved.assign(rows, 0);
  for (std::size_t row = 0; row < rows; row++)
    sleep.awake[row] = !sleeps(sleep.still[row]) || (coarse && is_probe_step(sleep.still[row]));
  sleep.carried = coarse && (!sleeps(sleep.coarse_still) || is_probe_step(sleep.coarse_still));
}

void spread_motion(const Model& model, State& state) {
  Sleep& sleep = state.sleep;
  for (int row = 0; row < int(sleep.moved.size()); row++)
    if (sleep.moved[std::size_t(row)])
      for_each_row_beside(model.lattice, row, 1, [&](int beside) { sleep.awake[std::size_t(beside)] = 1; });
}

void lay_down_rows(const Exec& exec, const Model& model, State& state, double dt, bool coarse) {
  Sleep& sleep = state.sleep;
  const auto for_each_row = [&](const auto& visit) {
    const int rows = model.lattice.size.y + 2;
    parallel_for(exec, std::size_t(model.lattice.size.z), [&](std::size_t k) {
      for (int row = int(k + 1) * rows; row < int(k + 2) * rows; row++)
        visit(row, sleep.awake[std::size_t(row)] != 0);
    });
  };
  if (sleep.carried)
    for_each_row([&](int row, bool awake) {
      if (!awake && is_carried_further(model, state, row, dt)) sleep.moved[std::size_t(row)] = 1;
    });
  for_each_row([&](int row, bool awake) {
    std::uint8_t& still = sleep.still[std::size_t(row)];
    const bool slept = sleeps(still), may_move = awake || sleep.carried;
    if (may_move && has_moved_near(model, state, row))
      still = 0;
    else if (!slept || coarse)
      grow_old(still);
    if (!slept && sleeps(still)) still = first_of_sleep(row);
    if (may_move && sleeps(still)) stop_row(model, state, row);
  });
}

void count_sleepers(const Model& model, State& state, StepReport& report) {
  for (std::size_t row = 0; row < state.sleep.still.size(); row++) {
    if (model.moving.row_begin[2 * row] == model.moving.row_begin[2 * row + 2]) continue;
    report.rows++;
    report.rows_asleep += sleeps(state.sleep.still[row]);
  }
  if (report.rows_asleep == report.rows)
    grow_old(state.sleep.coarse_still);
  else
    state.sleep.coarse_still = 0;
}

}  // namespace turgor::lattice
