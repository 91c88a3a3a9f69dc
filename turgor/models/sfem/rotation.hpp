// Large rotations. Linear elasticity treats a rotated element as a swollen one. Here every element is
// measured in a rotated frame, R K (Rᵀ x − X) [Müller, Gross 2004], and the difference to K u is applied to
// the linear body as forces: u = Ξ (f + f_rot(u)). R is the rotation of the region around the element.
// Rotations of single elements, as below a fingertip, remain linear, so that the solver avoids the many
// equilibria between which single elements can flip. It runs beside the haptic tick, which only adds the free
// displacement Ξ f_rot(u) to its linear response.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

/// Constant data of rotated elements.
struct Corotation {
  int averaging = 2;  // number of times an element's displacement gradient is averaged over its neighbors
  std::vector<double> matrices;  // of all elements, one behind the other [N/m]
  std::vector<Vec3d> gradient;   // of each corner's shape function, at the element's center [1/m]
  Lists around;                  // elements around each vertex
  NodalVolumes volumes;          // of averaged tetrahedra, else empty
  std::vector<int> volume_of;    // for each element's corners, which of `volumes`
  std::vector<double> bulk;      // of each nodal volume, its modulus over its volume [Pa/m³]
};
/// With `averaging` = 0 every element has its own rotation.
Corotation make_corotation(const Exec& exec, const Model& model, int averaging = 2);

/// The rotation nearest to a matrix, searched from a guess; also for a matrix that turns inside out.
Mat3d nearest_rotation(const Mat3d& f, Mat3d guess);

/// Rotations of the regions around all elements at displacements of the free nodes, from those they had.
void update_rotations(const Exec& exec, const Model& model, const Corotation& corotation,
                      std::span<const double> u, std::vector<Mat3d>& rotation);
/// Forces of the elements on the free nodes [N].
void element_forces(const Exec& exec, const Model& model, const Corotation& corotation,
                    const std::vector<Mat3d>& rotation, std::span<const double> u, std::span<double> forces);
/// Derivative of these forces along u with fixed rotations: Σ R K Rᵀ u [N].
void turned_stiffness_times(const Exec& exec, const Model& model, const Corotation& corotation,
                            const std::vector<Mat3d>& rotation, std::span<const double> u,
                            std::span<double> forces);

/// History of the iteration: changes of the displacement from round to round, and changes of the steps that
/// the rounds computed. All by free node [m].
struct RoundHistory {
  std::vector<std::vector<double>> moves, changes;  // newest last
  std::vector<double> u, step;                      // of the last round; empty = none
};

struct RotationState {
  // Result:
  std::vector<Vec3d> displacement;  // of all vertices [m]
  std::vector<Vec3d> free;          // nonlinear part of the displacement [m]
  // State of the iteration:
  std::vector<Mat3d> rotation;  // of each element
  std::vector<double> u;        // by free node [m]
  std::vector<double> forces;   // by free node, of the last call [N]
  RoundHistory history;
  int idle = 0;  // rounds since the imbalance fell
};
RotationState make_rotation_state(const Model& model);

struct RotationParams {
  int most_solves = 12;     // with the factor, in one call
  double tolerance = 1e-3;  // of the residual
};

struct RotationReport {
  int solves = 0;
  double residual = 0;     // of f = Ξ⁻¹ u − f_rot(u), by energy in parts of the linear body's
  bool converged = false;  // if not, further calls continue, unless
  bool stuck = false;      // the residual does not fall any more
};

/// Continues the iteration towards the equilibrium under these forces on all vertices [N]. The result is the
/// displacement of least residual in this call. Requires the factor.
RotationReport correct_rotations(const Exec& exec, const Model& model, const Corotation& corotation,
                                 std::span<const Vec3d> forces, const RotationParams& params,
                                 RotationState& state);

}  // namespace turgor::sfem
