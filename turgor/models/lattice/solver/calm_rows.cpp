#include "turgor/models/lattice/solver/calm_rows.hpp"

#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"

namespace turgor::lattice {

void choose_swept_rows(const Model& model, const State& state, const Inputs& inputs, CalmRows& rows) {
  const std::vector<std::uint8_t>& awake = state.sleep.awake;
  // first sweep, and steps with contacts
  if (rows.visited.empty() || !inputs.contacts.empty()) {
    rows.swept = rows.visited = awake;
    rows.stirred.assign(awake.size(), 0);
    return;
  }
  // rows beside motion and springs
  std::vector<std::uint8_t> near(awake.size());
  const auto mark = [&](int row) {
    for_each_neighbor_row(model.anatomy.lattice, row, 1, [&](int neighbor) {
      if (is_index(neighbor, near.size())) near[std::size_t(neighbor)] = 1;
    });
  };
  for (std::size_t row = 0; row < awake.size(); row++)
    if (rows.stirred[row]) mark(int(row));
  if (inputs.springs)
    for (const PointSpring& spring : inputs.springs->all) mark(row_of(model, spring.at.cell));
  // those of them that are awake, rows at cuts, and rows that woke in this step
  for (std::size_t row = 0; row < awake.size(); row++) {
    rows.swept[row] = awake[row] && (near[row] || state.cuts.row_cut[row] || !rows.visited[row]);
    rows.visited[row] |= rows.swept[row];
  }
  rows.stirred.assign(awake.size(), 0);
}

}  // namespace turgor::lattice
