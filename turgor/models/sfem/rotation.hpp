// Large rotations. Linear elasticity takes a turned element for a swollen one; here every element is measured
// in a turned frame, R K (Rᵀ x − X) [Müller, Gross 2004], and what that differs from K u is given to the
// linear body as forces: u = Ξ (f + f_rot(u)). R is the rotation of the region around the element: what turns
// a single element, as a fingertip does, is left to the linear answer, and the search for the equilibrium
// does not meet the many states between which single elements can flip. It is solved beside the haptic tick,
// which only adds the free displacement Ξ f_rot(u) to its linear answer.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

/// What turned elements need to know and no step changes.
struct Corotation {
  int averaging = 2;             // rounds in which an element's motion becomes the mean of those around it
  std::vector<double> matrices;  // of all elements, one behind the other [N/m]
  std::vector<Vec3d> gradient;   // of each corner's shape function, at the element's centre [1/m]
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
/// What the elements exert on the free nodes [N].
void element_forces(const Exec& exec, const Model& model, const Corotation& corotation,
                    const std::vector<Mat3d>& rotation, std::span<const double> u, std::span<double> forces);
/// How these forces change with u while no element turns further: Σ R K Rᵀ u [N].
void turned_stiffness_times(const Exec& exec, const Model& model, const Corotation& corotation,
                            const std::vector<Mat3d>& rotation, std::span<const double> u,
                            std::span<double> forces);

/// What the rounds of the search were like: how the displacement changed from one to the next, and how the
/// steps did that they asked for. All by free node [m].
struct RoundHistory {
  std::vector<std::vector<double>> moves, changes;  // newest last
  std::vector<double> u, step;                      // of the last round; empty = none
};

struct RotationState {
  // What was found:
  std::vector<Vec3d> displacement;  // of all vertices [m]
  std::vector<Vec3d> free;          // the part that is not the linear answer to the forces [m]
  // Where the search is:
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
  bool converged = false;  // if not, call again to go on, unless
  bool stuck = false;      // the residual does not fall any more
};

/// Searches on towards the equilibrium with these forces on all vertices [N]; what is found is the
/// displacement of least residual that this call has met. The model has a factor.
RotationReport correct_rotations(const Exec& exec, const Model& model, const Corotation& corotation,
                                 std::span<const Vec3d> forces, const RotationParams& params,
                                 RotationState& state);

}  // namespace turgor::sfem
