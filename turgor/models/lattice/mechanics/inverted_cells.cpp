#include "turgor/models/lattice/mechanics/inverted_cells.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// True if the cell is uncut tissue with negative volume at its center.
bool is_inverted(const Model& model, const State& state, Int3 corner) {
  Vec3d x[kCellCorners];
  for (int n = 0; n < kCellCorners; n++) {
    const Int3 node = corner + cell_corner(n);
    const auto slot = std::size_t(node_slot(model.anatomy.lattice, node));
    if (!is_body(model.anatomy.tissue[slot]) || state.cuts.removed[slot]) return false;
    if (state.cuts.cut[slot] & edges_from_corner(n)) return false;
    x[n] = Vec3d(position(model, state.motion, node));
  }
  Vec3d slope[3];
  for (int n = 0; n < kCellCorners; n++)
    for (int axis = 0; axis < 3; axis++) slope[axis] += x[n] * double(corner_sign(n)[axis]);
  return dot(slope[0], cross(slope[1], slope[2])) < 0;
}

bool is_body_at(const Model& model, Vec3d x) {
  const Vec3 spacing = model.anatomy.lattice.spacing;
  const Int3 node{int(std::lround(x.x / spacing.x)), int(std::lround(x.y / spacing.y)),
                  int(std::lround(x.z / spacing.z))};
  return contains(model.anatomy.lattice, node) &&
         is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, node))]);
}

}  // namespace

InvertedCells find_inverted_cells(const Exec& exec, const Model& model, const State& state) {
  const Int3 cells = model.anatomy.lattice.size - Int3{1, 1, 1};
  std::vector<InvertedCells> layers(std::size_t(cells.z));
  parallel_for(exec, layers.size(), [&](std::size_t k) {
    for (int j = 0; j < cells.y; j++)
      for (int i = 0; i < cells.x; i++)
        if (const Int3 corner{i, j, int(k)}; is_inverted(model, state, corner))
          if (layers[k].count++ == 0) layers[k].first = corner;
  });
  InvertedCells all;
  for (const InvertedCells& layer : layers) {
    if (all.count == 0) all.first = layer.first;
    all.count += layer.count;
  }
  return all;
}

double cells_below(const Model& model, Vec3d from, Vec3d to, Vec3d into, double most) {
  const Vec3d spacing(model.anatomy.lattice.spacing);
  TURGOR_CHECK(is_unit(into), "the direction into the body is a unit vector");
  const double cell = norm(hadamard(into, spacing));  // size of a cell along `into` [m]
  const int points = 1 + int(std::ceil(norm(to - from) / std::min({spacing.x, spacing.y, spacing.z})));
  double least = most;
  for (int p = 0; p <= points; p++) {
    const Vec3d bottom = from + (to - from) * (double(p) / points);
    double below = 0;
    while (below < least && is_body_at(model, bottom + into * ((below + 0.25) * cell))) below += 0.25;
    least = std::min(least, below);
  }
  return least;
}

}  // namespace turgor::lattice
