// Columns of displacements at points as combinations of the coarse unknowns, for stiffnesses of low rank that
// the coarse operator does not contain (coupled_points.hpp, contact_columns.hpp).
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/coarse/coarse_correction.hpp"

namespace turgor::lattice {

/// Number of an unknown's component, and the derivative of a displacement by it.
struct CoupledTerm {
  int number = 0;
  double weight = 0;
};

/// Matrix U, column by column [1].
struct PointColumns {
  std::vector<int> begin{0};  // by column, and the end: indices into `terms`
  std::vector<CoupledTerm> terms;

  std::size_t count() const { return begin.size() - 1; }
  std::span<const CoupledTerm> column(std::size_t c) const {
    return std::span(terms).subspan(std::size_t(begin[c]), std::size_t(begin[c + 1] - begin[c]));
  }
  /// Appends a column, and sums its terms of the same number.
  void add(std::vector<CoupledTerm> column);
};

/// Displacements of nodes and virtual nodes as combinations of the unknowns.
class PointRows {
 public:
  PointRows(const Model& model, const State& state, const CoarseSpace& space);
  /// Adds g · u of a node or virtual node.
  void add_node(int corner, Vec3d g, std::vector<CoupledTerm>& column) const;

 private:
  void add_row(int row, Vec3d g, std::vector<CoupledTerm>& column) const;

  const Model& model_;
  const CoarseSpace& space_;
  std::vector<int> virtual_node_slot_;
};

/// Displacement Uᵀ x of a column [m].
double displacement_of(std::span<const CoupledTerm> column, std::span<const double> x);

/// Uᵀ A⁻¹ V, row by row, for the factor of A [m/N].
std::vector<double> displacements_between(const CoarseFactor& factor, const PointColumns& u,
                                          const PointColumns& v);

}  // namespace turgor::lattice
