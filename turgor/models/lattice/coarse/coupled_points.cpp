// Columns of coupled displacements and the Woodbury formula.
#include "turgor/models/lattice/coarse/coupled_points.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::lattice {

namespace {

/// Columns that are solved at once.
constexpr std::size_t kColumns = 8;
using ColumnLanes = std::array<double, kColumns>;

std::vector<CoupledPoint> coupled_points_of(const PointSprings* springs) {
  std::vector<CoupledPoint> points;
  if (springs == nullptr) return points;
  int left = 0;  // springs of the present coupling
  for (const PointSpring& spring : springs->all) {
    if (spring.coupling.count > 0) left = spring.coupling.count;
    if (left-- > 0) points.push_back({spring.at, spring.coupling.direction, spring.coupling.count});
  }
  return points;
}

/// Displacement of points as a combination of the unknowns.
struct PointRows {
  const Model& model;
  const CoarseSpace& space;
  std::vector<int> virtual_node_slot;

  PointRows(const Model& m, const State& state, const CoarseSpace& of)
      : model(m), space(of), virtual_node_slot(state.motion.virtual_u.size(), -1) {
    const int slots = slot_count(m.anatomy.lattice);
    for (const ElementNode& node : state.cut_elements.virtual_nodes)
      virtual_node_slot[std::size_t(node.corner - slots)] = node.slot;
  }

  /// Adds a row of the space, times g.
  void add_row(int row, Vec3d g, std::vector<CoupledTerm>& column) const {
    for (int t = space.row_begin[std::size_t(row)]; t < space.row_begin[std::size_t(row) + 1]; t++)
      for (int axis = 0; axis < 3; axis++) {
        const CoarseTerm& term = space.terms[std::size_t(t)];
        column.push_back({3 * term.unknown + axis, double(term.weight) * g[axis]});
      }
  }
  /// Adds g · u of a node.
  void add_node(int corner, Vec3d g, std::vector<CoupledTerm>& column) const {
    const int slots = slot_count(model.anatomy.lattice), from = space.interpolation[std::size_t(corner)];
    if (from == CoarseSpace::kFixed) return;
    if (from < 0) return add_row(-2 - from, g, column);
    const int slot = corner < slots ? corner : virtual_node_slot[std::size_t(corner - slots)];
    const CoarseBlock& block = space.blocks[std::size_t(from)];
    const std::array<float, 8> weights = corner_weights(block, slot_node(model.anatomy.lattice, slot));
    for (std::size_t c = 0; c < 8; c++)
      if (weights[c] != 0) add_row(block.corner[c], g * double(weights[c]), column);
  }
  void add(const CoupledPoint& point, std::vector<CoupledTerm>& column) const {
    for (std::size_t c = 0; c < 8; c++)
      if (point.at.weight[c] != 0)
        add_node(point.at.corner[c], Vec3d(point.direction) * double(point.at.weight[c]), column);
  }
};

/// Sums terms of the same number.
void merge_terms(std::vector<CoupledTerm>& column) {
  std::stable_sort(column.begin(), column.end(),
                   [](const CoupledTerm& a, const CoupledTerm& b) { return a.number < b.number; });
  std::size_t end = 0;
  for (const CoupledTerm& term : column)
    if (end > 0 && column[end - 1].number == term.number)
      column[end - 1].weight += term.weight;
    else
      column[end++] = term;
  column.resize(end);
}

void find_columns(const PointRows& rows, CoupledPoints& coupled) {
  std::vector<CoupledTerm> column;
  coupled.begin = {0};
  for (std::size_t p = 0; p < coupled.points.size();) {
    // points of one coupling
    const auto end = std::min(p + std::size_t(std::max(1, coupled.points[p].count)), coupled.points.size());
    column.clear();
    for (; p < end; p++) rows.add(coupled.points[p], column);
    merge_terms(column);
    coupled.terms.insert(coupled.terms.end(), column.begin(), column.end());
    coupled.begin.push_back(int(coupled.terms.size()));
  }
  TURGOR_CHECK(is_csr(coupled.begin, coupled.terms.size()), "the columns cover all terms");
}

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

/// Uᵀ A⁻¹ U.
void find_displacements(const CoarseFactor& factor, CoupledPoints& coupled) {
  const std::size_t count = coupled.count();
  coupled.displacement.assign(count * count, 0);
  std::vector<ColumnLanes> x;
  for (std::size_t first = 0; first < count; first += kColumns) {
    const std::size_t lanes = std::min(kColumns, count - first);
    // A⁻¹ U of some columns
    x.assign(factor.order.size(), {});
    for (std::size_t n = 0; n < lanes; n++)
      for (const CoupledTerm& t : coupled.column(first + n))
        x[std::size_t(factor.order[std::size_t(t.number)])][n] = t.weight;
    solve_columns(factor, x);
    // rows of these columns
    for (std::size_t c = 0; c < count; c++)
      for (const CoupledTerm& t : coupled.column(c))
        for (std::size_t n = 0; n < lanes; n++)
          coupled.displacement[(first + n) * count + c] +=
              t.weight * x[std::size_t(factor.order[std::size_t(t.number)])][n];
  }
}

/// Columns with a stiffness at present, and its root.
struct TautColumns {
  std::vector<std::size_t> column;
  std::vector<double> root;  // √k [√(N/m)]

  TautColumns(const CoupledPoints& coupled, const PointSprings& springs) {
    std::size_t next = 0;
    for (const PointSpring& spring : springs.all) {
      if (spring.coupling.count == 0) continue;
      if (spring.coupling.stiffness > 0)
        column.push_back(next), root.push_back(std::sqrt(double(spring.coupling.stiffness)));
      next++;
    }
    TURGOR_CHECK(next == coupled.count(), "every coupling has a column");
  }
};

/// Coupled displacement Uᵀ x of a column [m].
double displacement_of(std::span<const CoupledTerm> column, std::span<const double> x) {
  double sum = 0;
  for (const CoupledTerm& t : column) sum += t.weight * x[std::size_t(t.number)];
  return sum;
}

}  // namespace

void couple_points(const Model& model, State& state, const PointSprings* springs) {
  std::shared_ptr<const CoarseSpace>& current = state.workspace.coarse;
  TURGOR_CHECK(current != nullptr, "points are coupled in a coarse space");
  std::vector<CoupledPoint> points = coupled_points_of(springs);
  if (current->unknowns == 0 || points == (current->coupled ? current->coupled->points : decltype(points)()))
    return;
  // copies of the state may share the space
  auto space = std::make_shared<CoarseSpace>(*current);
  space->coupled = nullptr;
  if (!points.empty()) {
    auto coupled = std::make_shared<CoupledPoints>();
    coupled->points = std::move(points);
    find_columns(PointRows(model, state, *space), *coupled);
    find_displacements(space->factor, *coupled);
    space->coupled = std::move(coupled);
  }
  current = std::move(space);
}

bool has_coupled_points(const State& state) {
  return state.workspace.coarse != nullptr && state.workspace.coarse->coupled != nullptr;
}

std::vector<double> solve_coupled(const CoarseSpace& space, const PointSprings* springs,
                                  std::span<const double> forces) {
  std::vector<double> x = space.factor.solve(forces);
  if (!space.coupled || springs == nullptr) return x;
  const CoupledPoints& coupled = *space.coupled;
  const TautColumns taut(coupled, *springs);
  const auto count = Eigen::Index(taut.column.size());
  if (count == 0) return x;
  // (1 + √K Uᵀ A⁻¹ U √K) z = √K Uᵀ A⁻¹ f, positive definite
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd z(count);
  for (Eigen::Index i = 0; i < count; i++) {
    const std::size_t a = taut.column[std::size_t(i)];
    const double root = taut.root[std::size_t(i)];
    for (Eigen::Index j = 0; j < count; j++)
      matrix(i, j) =
          (i == j ? 1 : 0) + root * taut.root[std::size_t(j)] *
                                 coupled.displacement[a * coupled.count() + taut.column[std::size_t(j)]];
    z[i] = root * displacement_of(coupled.column(a), x);
  }
  z = matrix.llt().solve(z).eval();
  // x = A⁻¹ (f − U y), y = √K z
  std::vector<double> rest(forces.begin(), forces.end());
  for (Eigen::Index i = 0; i < count; i++)
    for (const CoupledTerm& t : coupled.column(taut.column[std::size_t(i)]))
      rest[std::size_t(t.number)] -= t.weight * taut.root[std::size_t(i)] * z[i];
  return space.factor.solve(rest);
}

std::size_t memory_bytes(const CoupledPoints& coupled) {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  return bytes(coupled.points) + bytes(coupled.begin) + bytes(coupled.terms) + bytes(coupled.displacement);
}

}  // namespace turgor::lattice
