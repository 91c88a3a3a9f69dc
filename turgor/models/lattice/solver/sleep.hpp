// Rows that sleep: a row near which nothing has gone faster than Params::solver.sleep for a few steps is not
// swept until something near it moves, is cut, touched or loaded, or gravity changes. What a row does depends
// on what rows did in sweeps before, never on when a thread came to them. Descent only.
// A body that lies as the CT shows it, and to which nothing has happened yet, begins asleep.
// Without a coarse space sleepers stand still. With one they follow the smooth part of the motion, without
// inertia, and wake when it takes them further. What is smooth leaves something undone in every row, so they
// are looked at, that is swept for a step, ever more rarely; and a coarse space is solved as rarely when all
// rows sleep.
#pragma once

#include <bit>

#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// So many steps in a row of nothing near that moves, and a row sleeps: at the turning point of a swing all
/// stands still, but not for long.
constexpr int kStillSteps = 8;
inline bool sleeps(std::uint8_t still) { return still >= kStillSteps; }
/// One that is carried is looked at after 16, 32, 64 and 128 steps, and after every 128 from then on.
inline bool is_probe_step(std::uint8_t still) { return still > kStillSteps && std::has_single_bit(still); }

inline bool can_sleep(const Model& model) {
  return model.params.solver.sleep > 0 && model.params.solver.method == Method::kVbd;
}
/// Rows are counted in the storage's order, its border among them.
inline int row_of(const Model& model, int slot) { return slot / row_stride(model.lattice); }

/// Calls visit(row) for a row and those up to `reach` beside it, of the storage's or not.
template <class Visit>
void for_each_row_beside(const Lattice& l, int row, int reach, const Visit& visit) {
  for (int k = -reach; k <= reach; k++)
    for (int j = -reach; j <= reach; j++) visit(row + k * (l.size.y + 2) + j);
}

/// Wakes the rows up to `reach` around a slot.
void wake_around(const Model& model, State& state, int slot, int reach);
/// Who is awake when a step begins: all but the sleepers, and those near cuts, loads and contacts. `coarse`:
/// there is a coarse space that the step can use.
void wake_rows(const Model& model, State& state, const Inputs& inputs, bool coarse);
/// After a sweep: wakes those beside what has moved in it, for the next.
void spread_motion(const Model& model, State& state);
/// At the end of a step: lays down rows near which nothing has moved for long enough, at rest where they are.
void lay_down_rows(const Exec& exec, const Model& model, State& state, double dt, bool coarse);
/// Notes in the report how many rows can move, and how many of these sleep after the step. When all do, so
/// will the coarse space.
void count_sleepers(const Model& model, State& state, StepReport& report);

}  // namespace turgor::lattice
