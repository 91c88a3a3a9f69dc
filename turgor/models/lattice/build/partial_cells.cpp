#include "turgor/models/lattice/build/partial_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::lattice {

namespace {

/// Offsets to the 26 neighbors of a node or cell, the nearest first; equal distances in lattice order.
const std::array<Int3, 26>& neighbors_by_distance() {
  static const std::array<Int3, 26> offsets = [] {
    std::array<Int3, 26> all{};
    std::size_t count = 0;
    for (int distance = 1; distance <= 3; distance++)
      for (int n = 0; n < 27; n++) {
        const Int3 o{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
        if (o.x * o.x + o.y * o.y + o.z * o.z == distance) all[count++] = o;
      }
    return all;
  }();
  return offsets;
}

int squared(Int3 o) { return o.x * o.x + o.y * o.y + o.z * o.z; }

/// Calls visit(n) for the body nodes among the 26 neighbors that are nearest to a node.
template <class Visit>
void for_nearest_body_nodes(const BodyNodes& nodes, Int3 node, const Visit& visit) {
  int distance = 0;
  for (const Int3 o : neighbors_by_distance()) {
    if (distance > 0 && squared(o) > distance) return;
    const Int3 at = node + o;
    if (!contains(nodes.grid, at)) continue;
    const std::size_t n = sample_index(nodes.grid, at.x, at.y, at.z);
    if (!is_body(nodes.tissue[n])) continue;
    distance = squared(o);
    visit(n);
  }
}

struct CellSearch {
  const BodyNodes& nodes;

  Tissue tissue(Int3 node) const { return nodes.tissue[sample_index(nodes.grid, node.x, node.y, node.z)]; }
  bool is_cell(Int3 cell) const {
    return contains(nodes.grid, cell) && contains(nodes.grid, cell + Int3{1, 1, 1});
  }
  /// True if some corners of a cell are body, none is gas, and a node of the cell or next to it is outside.
  bool may_be_partial(Int3 cell) const {
    bool body = false, outside = false;
    for (int c = 0; c < kCellCorners; c++) {
      const Tissue t = tissue(cell + cell_corner(c));
      if (t == Tissue::kGas) return false;
      body |= is_body(t), outside |= !is_body(t);
    }
    if (!body || outside) return body;
    const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
               high = min(cell + Int3{2, 2, 2}, nodes.grid.size - Int3{1, 1, 1});
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (!is_body(tissue({i, j, k}))) return true;
    return false;
  }
  bool is_full(Int3 cell) const {
    for (int c = 0; c < kCellCorners; c++)
      if (!is_body(tissue(cell + cell_corner(c)))) return false;
    return true;
  }
};

/// A cell near the surface.
struct NearSurface {
  Int3 cell;
  CellVoxels voxels;
};
double filled_fraction(const CellVoxels& v) { return v.all > 0 ? double(v.body) / double(v.all) : 0; }

/// Cells near the surface in lattice order.
std::vector<NearSurface> find_near_surface(const Exec& exec, const VoxelsOfCell& voxels,
                                           const BodyNodes& nodes) {
  const CellSearch search{nodes};
  const Int3 cells = nodes.grid.size - Int3{1, 1, 1};
  std::vector<std::vector<NearSurface>> layers(std::size_t(std::max(cells.z, 0)));
  parallel_for(exec, layers.size(), [&](std::size_t k) {
    for (int j = 0; j < cells.y; j++)
      for (int i = 0; i < cells.x; i++) {
        const Int3 cell{i, j, int(k)};
        if (!search.may_be_partial(cell)) continue;
        layers[k].push_back({cell, voxels(cell + Int3{0, 0, nodes.first})});
      }
  });
  std::vector<NearSurface> all;
  for (const auto& layer : layers) all.insert(all.end(), layer.begin(), layer.end());
  return all;
}

/// Center of the body voxels relative to that of the scan's voxels in the cell, in half cells.
CellCenter center_of(const CellVoxels& v, Int3 block) {
  Vec3d at;
  for (int axis = 0; axis < 3 && v.body > 0 && v.all > 0; axis++)
    at[axis] = (double(v.sum_body[std::size_t(axis)]) / double(v.body) -
                double(v.sum_all[std::size_t(axis)]) / double(v.all)) /
               double(block[axis]);
  return packed_center(at);
}

}  // namespace

CellVoxels count_voxels(const CtSlab& ct, const Surroundings& surroundings, double air_max, Int3 block,
                        Int3 cell) {
  TURGOR_CHECK(block.x > 0 && block.y > 0 && block.z > 0, "a block has at least one voxel");
  const Int3 from = hadamard(cell, block), to = min(from + block, ct.whole.size);
  const AirLevel level{ct, surroundings, air_max};
  CellVoxels found;
  for (int k = from.z; k < to.z; k++)
    for (int j = from.y; j < to.y; j++)
      for (int i = from.x; i < to.x; i++) {
        const bool body = level.is_body({i, j, k});
        const Int3 at = (Int3{i, j, k} - from) * 2 + Int3{1, 1, 1} - block;
        found.all++, found.body += body;
        for (int axis = 0; axis < 3; axis++) {
          found.sum_all[std::size_t(axis)] += at[axis];
          found.sum_body[std::size_t(axis)] += body ? at[axis] : 0;
        }
      }
  return found;
}

void find_partial_cells(const Exec& exec, const VoxelsOfCell& voxels, Int3 block, BodyNodes& nodes) {
  const std::size_t count = sample_count(nodes.grid);
  TURGOR_ASSERT(nodes.tissue.size() == count && nodes.young.size() == count,
                "every node has a tissue and a modulus");
  // cells near the surface
  const std::vector<NearSurface> cells = find_near_surface(exec, voxels, nodes);
  // fractions and centers; cells elsewhere are full
  nodes.fill.fraction.assign(count, 1);
  nodes.fill.center.assign(count, {});
  const CellSearch search{nodes};
  for (int k = 0; k + 1 < nodes.grid.size.z; k++)
    for (int j = 0; j + 1 < nodes.grid.size.y; j++)
      for (int i = 0; i + 1 < nodes.grid.size.x; i++)
        if (!search.is_full({i, j, k})) nodes.fill.fraction[sample_index(nodes.grid, i, j, k)] = 0;
  for (const NearSurface& near : cells) {
    const std::size_t n = sample_index(nodes.grid, near.cell.x, near.cell.y, near.cell.z);
    nodes.fill.fraction[n] = float(std::max(filled_fraction(near.voxels), kLeastFraction));
    nodes.fill.center[n] = center_of(near.voxels, block);
  }
  TURGOR_CHECK(all_finite(nodes.fill.fraction), "filled fractions are finite");
  // rim nodes
  for (const NearSurface& near : cells) {
    for (int c = 0; c < kCellCorners; c++) {
      const Int3 node = near.cell + cell_corner(c);
      const std::size_t n = sample_index(nodes.grid, node.x, node.y, node.z);
      if (is_body(nodes.tissue[n]) || nodes.young[n] > 0) continue;
      double sum = 0;
      int nearest = 0;
      for_nearest_body_nodes(nodes, node, [&](std::size_t other) { sum += nodes.young[other], nearest++; });
      TURGOR_CHECK(nearest > 0, "a rim node is next to a body node");
      nodes.young[n] = float(sum / nearest);
    }
  }
}

void find_surfaces(const Exec& exec, const CrossingOfEdge& crossing, BodyNodes& nodes) {
  const CellSearch search{nodes};
  const Int3 cells = nodes.grid.size - Int3{1, 1, 1};
  std::vector<std::vector<CellSurface>> layers(std::size_t(std::max(cells.z, 0)));
  parallel_for(exec, layers.size(), [&](std::size_t k) {
    for (int j = 0; j < cells.y; j++)
      for (int i = 0; i < cells.x; i++) {
        const Int3 cell{i, j, int(k)};
        if (search.is_full(cell) || !search.may_be_partial(cell)) continue;
        std::array<bool, kCellCorners> is_body_corner{};
        for (int c = 0; c < kCellCorners; c++)
          is_body_corner[std::size_t(c)] = is_body(search.tissue(cell + cell_corner(c)));
        const CellSurface found =
            surface_in_cell(cell, nodes.first, nodes.grid.spacing, is_body_corner, crossing);
        if (norm(Vec3d(found.area)) > 0) layers[k].push_back(found);
      }
  });
  nodes.surface.clear();
  for (const auto& layer : layers) nodes.surface.insert(nodes.surface.end(), layer.begin(), layer.end());
}

std::vector<std::uint8_t> fixed_with_rim(const Exec& exec, const BodyNodes& nodes) {
  std::vector<std::uint8_t> fixed = nodes.fixed;
  if (nodes.fill.fraction.empty()) return fixed;
  parallel_for(exec, std::size_t(nodes.grid.size.z), [&](std::size_t k) {
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, int(k));
        if (is_body(nodes.tissue[n]) || !(nodes.young[n] > 0)) continue;
        bool all = true;
        for_nearest_body_nodes(nodes, {i, j, int(k)},
                               [&](std::size_t other) { all &= nodes.fixed[other] != 0; });
        fixed[n] = all;
      }
  });
  return fixed;
}

}  // namespace turgor::lattice
