#include "turgor/models/lattice/coarse/point_columns.hpp"

#include <algorithm>
#include <array>

#include "turgor/core/invariants.hpp"

namespace turgor::lattice {

namespace {

/// Columns that are solved at once.
constexpr std::size_t kColumns = 8;
using ColumnLanes = std::array<double, kColumns>;

/// CoarseFactor::solve for several columns, in the order of elimination. Rows of zeros are skipped.
void solve_columns(const CoarseFactor& factor, std::vector<ColumnLanes>& x) {
  // forward substitution
  for (std::size_t c = 0; c < x.size(); c++) {
    const ColumnLanes at = x[c];
    if (std::all_of(at.begin(), at.end(), [](double a) { return a == 0; })) continue;
    for (std::uint32_t p = factor.column[c]; p < factor.column[c + 1]; p++)
      for (std::size_t n = 0; n < kColumns; n++) x[factor.row[p]][n] -= double(factor.value[p]) * at[n];
  }
  // diagonal and backward substitution
  for (std::size_t c = x.size(); c-- > 0;) {
    ColumnLanes at = x[c];
    for (double& a : at) a *= double(factor.inverse_diagonal[c]);
    for (std::uint32_t p = factor.column[c]; p < factor.column[c + 1]; p++)
      for (std::size_t n = 0; n < kColumns; n++) at[n] -= double(factor.value[p]) * x[factor.row[p]][n];
    x[c] = at;
  }
}

}  // namespace

void PointColumns::add(std::vector<CoupledTerm> column) {
  std::stable_sort(column.begin(), column.end(),
                   [](const CoupledTerm& a, const CoupledTerm& b) { return a.number < b.number; });
  std::size_t end = 0;
  for (const CoupledTerm& term : column)
    if (end > 0 && column[end - 1].number == term.number)
      column[end - 1].weight += term.weight;
    else
      column[end++] = term;
  terms.insert(terms.end(), column.begin(), column.begin() + std::ptrdiff_t(end));
  begin.push_back(int(terms.size()));
  TURGOR_CHECK(is_csr(begin, terms.size()), "the columns cover all terms");
}

PointRows::PointRows(const Model& model, const State& state, const CoarseSpace& space)
    : model_(model), space_(space), virtual_node_slot_(state.motion.virtual_u.size(), -1) {
  const int slots = slot_count(model.anatomy.lattice);
  for (const ElementNode& node : state.cut_elements.virtual_nodes)
    virtual_node_slot_[std::size_t(node.corner - slots)] = node.slot;
}

void PointRows::add_row(int row, Vec3d g, std::vector<CoupledTerm>& column) const {
  for (int t = space_.row_begin[std::size_t(row)]; t < space_.row_begin[std::size_t(row) + 1]; t++)
    for (int axis = 0; axis < 3; axis++) {
      const CoarseTerm& term = space_.terms[std::size_t(t)];
      column.push_back({3 * term.unknown + axis, double(term.weight) * g[axis]});
    }
}

void PointRows::add_node(int corner, Vec3d g, std::vector<CoupledTerm>& column) const {
  const int slots = slot_count(model_.anatomy.lattice), from = space_.interpolation[std::size_t(corner)];
  if (from == CoarseSpace::kFixed) return;
  if (from < 0) return add_row(-2 - from, g, column);
  const int slot = corner < slots ? corner : virtual_node_slot_[std::size_t(corner - slots)];
  const CoarseBlock& block = space_.blocks[std::size_t(from)];
  const std::array<float, 8> weights = corner_weights(block, slot_node(model_.anatomy.lattice, slot));
  for (std::size_t c = 0; c < 8; c++)
    if (weights[c] != 0) add_row(block.corner[c], g * double(weights[c]), column);
}

double displacement_of(std::span<const CoupledTerm> column, std::span<const double> x) {
  double sum = 0;
  for (const CoupledTerm& t : column) sum += t.weight * x[std::size_t(t.number)];
  return sum;
}

std::vector<double> displacements_between(const CoarseFactor& factor, const PointColumns& u,
                                          const PointColumns& v) {
  std::vector<double> displacement(u.count() * v.count(), 0);
  std::vector<ColumnLanes> x;
  for (std::size_t first = 0; first < v.count(); first += kColumns) {
    const std::size_t lanes = std::min(kColumns, v.count() - first);
    // A⁻¹ V of some columns
    x.assign(factor.order.size(), {});
    for (std::size_t n = 0; n < lanes; n++)
      for (const CoupledTerm& t : v.column(first + n))
        x[std::size_t(factor.order[std::size_t(t.number)])][n] = t.weight;
    solve_columns(factor, x);
    // rows of these columns
    for (std::size_t c = 0; c < u.count(); c++)
      for (const CoupledTerm& t : u.column(c))
        for (std::size_t n = 0; n < lanes; n++)
          displacement[c * v.count() + first + n] +=
              t.weight * x[std::size_t(factor.order[std::size_t(t.number)])][n];
  }
  return displacement;
}

}  // namespace turgor::lattice
