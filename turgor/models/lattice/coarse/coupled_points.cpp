// Columns of coupled displacements and the Woodbury formula.
#include "turgor/models/lattice/coarse/coupled_points.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/invariants.hpp"

namespace turgor::lattice {

namespace {

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

/// Adds a point's displacement along its direction.
void add_point(const PointRows& rows, const CoupledPoint& point, std::vector<CoupledTerm>& column) {
  for (std::size_t c = 0; c < 8; c++)
    if (point.at.weight[c] != 0)
      rows.add_node(point.at.corner[c], Vec3d(point.direction) * double(point.at.weight[c]), column);
}

void find_columns(const PointRows& rows, CoupledPoints& coupled) {
  std::vector<CoupledTerm> column;
  for (std::size_t p = 0; p < coupled.points.size();) {
    // points of one coupling
    const auto end = std::min(p + std::size_t(std::max(1, coupled.points[p].count)), coupled.points.size());
    column.clear();
    for (; p < end; p++) add_point(rows, coupled.points[p], column);
    coupled.columns.add(column);
  }
}

/// Columns with a stiffness at present: those of taut couplings, then all of contacts.
struct StiffColumns {
  std::vector<std::size_t> taut;  // columns of couplings
  std::vector<double> root;       // √k by column, of contacts 1 [√(N/m)]

  StiffColumns(const CoarseSpace& space, const PointSprings* springs, const ContactColumns& contacts) {
    if (space.coupled && springs) {
      std::size_t next = 0;
      for (const PointSpring& spring : springs->all) {
        if (spring.coupling.count == 0) continue;
        if (spring.coupling.stiffness > 0)
          taut.push_back(next), root.push_back(std::sqrt(double(spring.coupling.stiffness)));
        next++;
      }
      TURGOR_CHECK(next == space.coupled->columns.count(), "every coupling has a column");
    }
    root.insert(root.end(), contacts.columns.count(), 1.0);
  }
  std::size_t count() const { return root.size(); }
  std::span<const CoupledTerm> column(const CoarseSpace& space, const ContactColumns& contacts,
                                      std::size_t c) const {
    return c < taut.size() ? space.coupled->columns.column(taut[c])
                           : contacts.columns.column(c - taut.size());
  }
  /// Entry of Uᵀ A⁻¹ U [m/N].
  double displacement(const CoarseSpace& space, const ContactColumns& contacts, std::size_t a,
                      std::size_t b) const {
    if (a > b) std::swap(a, b);
    const std::size_t width = contacts.columns.count();
    if (b < taut.size())
      return space.coupled->displacement[taut[a] * space.coupled->columns.count() + taut[b]];
    if (a < taut.size()) return contacts.of_couplings[taut[a] * width + b - taut.size()];
    return contacts.displacement[(a - taut.size()) * width + b - taut.size()];
  }
};

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
    coupled->displacement = displacements_between(space->factor, coupled->columns, coupled->columns);
    space->coupled = std::move(coupled);
  }
  current = std::move(space);
}

bool has_coupled_points(const State& state) {
  return state.workspace.coarse != nullptr && state.workspace.coarse->coupled != nullptr;
}

std::vector<double> solve_coupled(const CoarseSpace& space, const PointSprings* springs,
                                  const ContactColumns& contacts, std::span<const double> forces) {
  std::vector<double> x = space.factor.solve(forces);
  const StiffColumns stiff(space, springs, contacts);
  const auto count = Eigen::Index(stiff.count());
  if (count == 0) return x;
  // (1 + √K Uᵀ A⁻¹ U √K) z = √K Uᵀ A⁻¹ f, positive definite
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd z(count);
  for (Eigen::Index i = 0; i < count; i++) {
    const auto a = std::size_t(i);
    for (Eigen::Index j = 0; j < count; j++)
      matrix(i, j) = (i == j ? 1 : 0) + stiff.root[a] * stiff.root[std::size_t(j)] *
                                            stiff.displacement(space, contacts, a, std::size_t(j));
    z[i] = stiff.root[a] * displacement_of(stiff.column(space, contacts, a), x);
  }
  z = matrix.llt().solve(z).eval();
  // x = A⁻¹ (f − U y), y = √K z
  std::vector<double> rest(forces.begin(), forces.end());
  for (Eigen::Index i = 0; i < count; i++)
    for (const CoupledTerm& t : stiff.column(space, contacts, std::size_t(i)))
      rest[std::size_t(t.number)] -= t.weight * stiff.root[std::size_t(i)] * z[i];
  return space.factor.solve(rest);
}

std::size_t memory_bytes(const CoupledPoints& coupled) {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  return bytes(coupled.points) + bytes(coupled.columns.begin) + bytes(coupled.columns.terms) +
         bytes(coupled.displacement);
}

}  // namespace turgor::lattice
