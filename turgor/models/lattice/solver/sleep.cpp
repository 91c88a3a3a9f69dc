#include "turgor/models/lattice/solver/sleep.hpp"

#include <algorithm>

#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

namespace {

bool is_storage_row(const State& state, int row) {
  return row >= 0 && std::size_t(row) < state.sleep.still_steps.size();
}

/// Wakes rows around cells that were cut since the last step.
void wake_cuts(const Model& model, State& state) {
  for (std::size_t n = state.sleep.cuts; n < state.cuts.edges.size(); n++)
    wake_around(model, state, state.cuts.edges[n].slot, 2);
  state.sleep.cuts = state.cuts.edges.size();
}

bool neighbor_moved(const Model& model, const State& state, int row) {
  bool any = false;
  for_each_neighbor_row(model.anatomy.lattice, row, 1, [&](int neighbor) {
    any |= is_storage_row(state, neighbor) && state.sleep.moved[std::size_t(neighbor)];
  });
  return any;
}

/// Calls visit(slot) for the free nodes of a row.
template <class Visit>
void for_each_slot(const Model& model, int row, const Visit& visit) {
  for (const int half_row : {2 * row, 2 * row + 1})
    for (const Run run : model.anatomy.free_runs.of_half_row(half_row))
      for (int s = run.begin; s < run.begin + run.count; s++) visit(std::size_t(s));
}

/// Stops a row at its current displacement.
void stop_row(const Model& model, Motion& motion, int row) {
  for_each_slot(model, row, [&](std::size_t s) {
    motion.u_before.set(s, motion.u[s]);
    motion.v.set(s, {});
  });
}

/// True if the coarse correction moved a node of the body in the row farther than a sleeping row may move.
bool coarse_motion_wakes(const Model& model, const Motion& motion, int row, double dt) {
  const Real distance = Real(model.params.solver.sleep_speed * dt);
  bool any = false;
  for_each_slot(model, row, [&](std::size_t s) {
    const Vec3 d = motion.u[s] - motion.u_before[s];
    any |= is_body(model.anatomy.tissue[s]) && !(dot(d, d) <= distance * distance);
  });
  return any;
}

/// Increments an age. Ages above 255 continue at 128, so that probe steps stay periodic.
void increment_age(std::uint8_t& still_steps) {
  constexpr std::uint8_t kOldest = 255, kLastProbe = 128;
  still_steps = still_steps == kOldest ? kLastProbe : std::uint8_t(still_steps + 1);
}

/// Initial age. It depends on the row, so that rows that fall asleep together are not probed together.
std::uint8_t initial_sleep_age(int row) { return std::uint8_t(kStillSteps + row % kStillSteps); }

/// True for the state of the CT without gravity. It is at rest, with or without skin tension
/// (measure_prestress).
bool is_initial_state(const State& state, const Inputs& inputs) {
  const auto is_zero = [](const VecField& field) {
    const auto all = [](const aligned_vector<Real>& axis) {
      return std::all_of(axis.begin(), axis.end(), [](Real a) { return a == 0; });
    };
    return all(field.x) && all(field.y) && all(field.z);
  };
  return cut_version(state.cuts) == 0 && inputs.gravity == Vec3d{} && is_zero(state.motion.u) &&
         is_zero(state.motion.v);
}

/// Initializes sleep: a body in its initial state starts asleep.
void begin_sleep(State& state, const Inputs& inputs) {
  Sleep& sleep = state.sleep;
  sleep.still_steps.assign(state.cuts.row_cut.size(), 0), sleep.coarse_still_steps = 0;
  if (!is_initial_state(state, inputs)) return;
  for (std::size_t row = 0; row < sleep.still_steps.size(); row++)
    sleep.still_steps[row] = initial_sleep_age(int(row));
}

}  // namespace

void wake_around(const Model& model, State& state, int slot, int reach) {
  for_each_neighbor_row(model.anatomy.lattice, row_of(model, slot), reach, [&](int row) {
    if (is_storage_row(state, row)) state.sleep.still_steps[std::size_t(row)] = 0;
  });
}

void wake_rows(const Model& model, State& state, const Inputs& inputs, bool coarse) {
  Sleep& sleep = state.sleep;
  const std::size_t rows = state.cuts.row_cut.size();
  // reset
  if (sleep.still_steps.size() != rows || !(sleep.gravity == inputs.gravity)) begin_sleep(state, inputs);
  sleep.gravity = inputs.gravity;
  // cuts, loads, contacts and springs at points
  const bool has_springs = inputs.springs != nullptr && !inputs.springs->settled;
  if (!coarse || sleep.cuts != state.cuts.edges.size() || !inputs.loads.empty() || has_springs)
    sleep.coarse_still_steps = 0;
  wake_cuts(model, state);
  for (const NodeLoad& load : inputs.loads) wake_around(model, state, load.slot, 1);
  for (const NodeContact& contact : inputs.contacts) wake_around(model, state, contact.slot, 1);
  if (has_springs)
    for (const PointSpring& spring : inputs.springs->all) wake_around(model, state, spring.at.cell, 2);
  // awake rows
  sleep.awake.resize(rows), sleep.moved.assign(rows, 0);
  for (std::size_t row = 0; row < rows; row++)
    sleep.awake[row] = !sleeps(sleep.still_steps[row]) || (coarse && is_probe_step(sleep.still_steps[row]));
  // coarse correction
  sleep.moved_by_coarse =
      coarse && (!sleeps(sleep.coarse_still_steps) || is_probe_step(sleep.coarse_still_steps));
}

void wake_neighbors(const Model& model, State& state) {
  Sleep& sleep = state.sleep;
  for (int row = 0; row < int(sleep.moved.size()); row++)
    if (sleep.moved[std::size_t(row)])
      for_each_neighbor_row(model.anatomy.lattice, row, 1,
                            [&](int neighbor) { sleep.awake[std::size_t(neighbor)] = 1; });
}

void put_rows_to_sleep(const Exec& exec, const Model& model, State& state, double dt, bool coarse) {
  Sleep& sleep = state.sleep;
  const auto for_each_row = [&](const auto& visit) {
    const int rows = model.anatomy.lattice.size.y + 2;
    parallel_for(exec, std::size_t(model.anatomy.lattice.size.z), [&](std::size_t k) {
      for (int row = int(k + 1) * rows; row < int(k + 2) * rows; row++)
        visit(row, sleep.awake[std::size_t(row)] != 0);
    });
  };
  // rows that the coarse correction moved too far
  if (sleep.moved_by_coarse)
    for_each_row([&](int row, bool awake) {
      if (!awake && coarse_motion_wakes(model, state.motion, row, dt)) sleep.moved[std::size_t(row)] = 1;
    });
  // ages
  for_each_row([&](int row, bool awake) {
    std::uint8_t& still_steps = sleep.still_steps[std::size_t(row)];
    const bool slept = sleeps(still_steps), may_move = awake || sleep.moved_by_coarse;
    if (may_move && neighbor_moved(model, state, row))
      still_steps = 0;
    else if (!slept || coarse)
      increment_age(still_steps);
    if (!slept && sleeps(still_steps)) still_steps = initial_sleep_age(row);
    if (may_move && sleeps(still_steps)) stop_row(model, state.motion, row);
  });
}

void count_sleeping_rows(const Model& model, State& state, StepReport& report) {
  for (std::size_t row = 0; row < state.sleep.still_steps.size(); row++) {
    if (model.anatomy.free_runs.row_begin[2 * row] == model.anatomy.free_runs.row_begin[2 * row + 2])
      continue;
    report.rows++;
    report.rows_asleep += sleeps(state.sleep.still_steps[row]);
  }
  if (report.rows_asleep == report.rows)
    increment_age(state.sleep.coarse_still_steps);
  else
    state.sleep.coarse_still_steps = 0;
}

}  // namespace turgor::lattice
