// Sleep of rows (VBD only). A row sleeps after a few steps in which no node of the body near it was faster
// than SolverParams::sleep_speed. Rim nodes, up to a spacing beyond the surface, exaggerate the motion of the
// body beside them and keep no row awake. A row wakes when something near it moves, is cut, touched or
// loaded, or when gravity changes. Sleep depends only on previous sweeps, never on the timing of threads.
//
// A body in its initial state starts asleep. Without a coarse space, sleeping rows stand still. With one,
// they follow the coarse correction without inertia, and wake when it moves them farther. Coarse corrections
// leave a residual in every row. So sleeping rows are swept in probe steps, which become rarer with age. The
// coarse space is solved as rarely when all rows sleep.
#pragma once

#include <bit>

#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Steps without motion nearby after which a row sleeps. A few are needed: at the turning point of an
/// oscillation everything stands still for a moment.
constexpr int kStillSteps = 8;
inline bool sleeps(std::uint8_t still_steps) { return still_steps >= kStillSteps; }
/// True in probe steps: at ages 16, 32, 64 and 128, then every 128 steps.
inline bool is_probe_step(std::uint8_t still_steps) {
  return still_steps > kStillSteps && std::has_single_bit(still_steps);
}

inline bool can_sleep(const Model& model) {
  return model.params.solver.sleep_speed > 0 && model.params.solver.method == Method::kVbd;
}
/// Row of the storage that contains a slot, border rows included.
inline int row_of(const Model& model, int slot) { return slot / row_stride(model.anatomy.lattice); }

/// Calls visit(row) for a row and its neighbors up to `reach`, inside the storage or not.
template <class Visit>
void for_each_neighbor_row(const Lattice& l, int row, int reach, const Visit& visit) {
  for (int k = -reach; k <= reach; k++)
    for (int j = -reach; j <= reach; j++) visit(row + k * (l.size.y + 2) + j);
}

/// Wakes the rows within `reach` of a slot.
void wake_around(const Model& model, State& state, int slot, int reach);
/// Determines the awake rows of a step: all rows that do not sleep, and rows near cuts, loads and contacts.
/// `coarse`: the step has a coarse space.
void wake_rows(const Model& model, State& state, const Inputs& inputs, bool coarse);
/// After a sweep: wakes the neighbors of rows that moved, for the next sweep.
void wake_neighbors(const Model& model, State& state);
/// At the end of a step: puts rows to sleep, at rest, if nothing near them moved for long enough.
void put_rows_to_sleep(const Exec& exec, const Model& model, State& state, double dt, bool coarse);
/// Reports the rows with free nodes and the sleeping ones among them. Ages the coarse space if all rows
/// sleep.
void count_sleeping_rows(const Model& model, State& state, StepReport& report);

}  // namespace turgor::lattice
