// Stitches in the coarse operator. A taut thread couples the points of its stitch, and walls that touch
// couple two points, each with a stiffness of rank one (PointCoupling). With U the coupled displacements and
// K their stiffnesses, the operator A + U K Uᵀ is solved with the factor of A:
//   x = A⁻¹ (f − U y),   (K⁻¹ + Uᵀ A⁻¹ U) y = Uᵀ A⁻¹ f
// Uᵀ A⁻¹ U is kept until points change, so that a stitch may become taut or slack without a factorization.
// Without the stitches, corrections are too long, and their step lengths fall to a tenth. [Woodbury 1950]
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/coarse/contact_columns.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

/// Point of a coupling.
struct CoupledPoint {
  EmbeddedPoint at;
  Vec3 direction;  // PointCoupling::direction
  int count = 0;   // PointCoupling::count

  friend bool operator==(const CoupledPoint&, const CoupledPoint&) = default;
};

/// Couplings of a body, in the order of its springs.
struct CoupledPoints {
  std::vector<CoupledPoint> points;
  PointColumns columns;              // U
  std::vector<double> displacement;  // Uᵀ A⁻¹ U, symmetric, row by row [m/N]
};

/// Sets CoarseSpace::coupled of the state's space for the couplings of these springs, if their points or the
/// space changed. Null or without couplings: none.
void couple_points(const Model& model, State& state, const PointSprings* springs);
/// True if stitches couple points in the coarse space of the state.
bool has_coupled_points(const State& state);

/// Solves the coarse operator with the present stiffnesses of the couplings and of contacts [m]. `forces`:
/// three components per unknown [N]. The springs are those of couple_points.
std::vector<double> solve_coupled(const CoarseSpace& space, const PointSprings* springs,
                                  const ContactColumns& contacts, std::span<const double> forces);

/// Memory of the couplings [bytes].
std::size_t memory_bytes(const CoupledPoints& coupled);

}  // namespace turgor::lattice
