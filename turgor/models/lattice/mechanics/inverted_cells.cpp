#include "turgor/models/lattice/mechanics/inverted_cells.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// Is the cell tissue with no cut in it, and its volume at the middle negative?
bool is_folded(const Model& model, const State& state, Int3 corner) {
  Vec3d x[kCellCorners];
  for (int n = 0; n < kCellCorners; n++) {
    const Int3 node = corner + cell_corner(n);
    const auto slot = std::size_t(node_slot(model.lattice, node));
    if (!is_body(model.tissue[slot]) || state.removed[slot]) return false;
    if (state.cut[slot] & edges_from_corner(n)) return false;
    x[n] = Vec3d(position(model, state, node));
  }
  Vec3d slope[3];
  for (int n = 0; n < kCellCorners; n++)
    for (int axis = 0; axis < 3; axis++) slope[axis] += x[n] * double(corner_side(n)[axis]);
  return dot(slope[0], cross(slope[1], slope[2])) < 0;
}

bool is_body_at(const Model& model, Vec3d x) {
  const Vec3 step = model.lattice.step;
  const Int3 node{int(std::lround(x.x / step.x)), int(std::lround(x.y / step.y)),
                  int(std::lround(x.z / step.z))};
  return contains(model.lattice, node) && is_body(model.tissue[std::size_t(node_slot(model.lattice, node))]);
}

}  // namespace

InvertedCells find_folded_cells(const Exec& exec, const Model& model, const State& state) {
  const Int3 cells = model.lattice.size - Int3{1, 1, 1};
  std::vector<InvertedCells> layers(std::size_t(cells.z));
  parallel_for(exec, layers.size(), [&](std::size_t k) {
    for (int j = 0; j < cells.y; j++)
      for (int i = 0; i < cells.x; i++)
        if (const Int3 corner{i, j, int(k)}; is_folded(model, state, corner))
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
  const Vec3d step(model.lattice.step);
  const double cell = norm(hadamard(into, step));  // of a step towards `into`
  const int points = 1 + int(std::ceil(norm(to - from) / std::min({step.x, step.y, step.z})));
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
