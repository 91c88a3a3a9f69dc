#include <Eigen/Dense>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/models/sfem/device_green.hpp"

namespace turgor::sfem {

namespace {

void add_tiles(int supernode, std::size_t rows, std::vector<RowTile>& tiles) {
  for (std::size_t first = 0; first < rows; first += RowTile::kRows) tiles.push_back({supernode, int(first)});
}

/// Replaces the factor of a block of D, in the lower triangle on top of a panel, by the inverse.
void invert_block(const Supernode& s, std::vector<double>& values) {
  const Eigen::Index width = 3 * s.count, height = width + 3 * Eigen::Index(s.row_count);
  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> top(&values[s.value_begin], width, width,
                                                           Eigen::OuterStride<>(height));
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(width, width);
  top.triangularView<Eigen::Lower>().solveInPlace(inverse);
  top = inverse.transpose() * inverse;
}

}  // namespace

ColumnPlan plan_columns(const Model& model) {
  TURGOR_ASSERT(model.factor.has_value(), "columns are planned from the factor");
  const Elimination& plan = model.factor->plan;
  ColumnPlan columns;
  // factor with inverted blocks, padded
  columns.values = model.factor->values;
  for (const Supernode& s : plan.supernodes) invert_block(s, columns.values);
  columns.values.resize(columns.values.size() + RowTile::kRows);
  // positions of the stored nodes
  columns.stored = stored_permutation(model, plan);
  const std::vector<unsigned char> wanted = with_ancestors(plan, columns.stored.rows);
  // tiles of rows by depth in the tree
  std::vector<std::size_t> depth(plan.supernodes.size());
  for (std::size_t n = plan.supernodes.size(); n-- > 0;)
    if (const int p = plan.supernodes[n].parent; p >= 0) depth[n] = depth[std::size_t(p)] + 1;
  for (std::size_t n = 0; n < plan.supernodes.size(); n++) {
    if (!wanted[n]) continue;
    if (columns.down.size() <= depth[n]) columns.down.resize(depth[n] + 1);
    add_tiles(int(n), 3 * std::size_t(plan.supernodes[n].count), columns.down[depth[n]]);
  }
  return columns;
}

UpPlan plan_up(const Elimination& plan, std::span<const int> rows) {
  UpPlan up{.on_path = with_ancestors(plan, rows), .tiles = {}, .begin = {0}};
  for (std::size_t n = 0; n < plan.supernodes.size(); n++) {
    if (!up.on_path[n] || plan.supernodes[n].row_count == 0) continue;
    add_tiles(int(n), 3 * plan.supernodes[n].row_count, up.tiles);
    up.begin.push_back(up.tiles.size());
  }
  TURGOR_CHECK(is_csr(up.begin, up.tiles.size()), "the supernodes cover all row tiles");
  return up;
}

}  // namespace turgor::sfem
