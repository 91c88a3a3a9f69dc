// Contact with Coulomb friction on a capacitance matrix: k sites of an elastic body, each pressed on by a
// tool (unilateral, with friction) or carried by one (held). Find the forces λ for which the separations
//
//     c = b + C λ        (three numbers a site; b: what they would be without any contact force)
//
// obey, at a held site, c = 0, and at every other one, with n pointing from the tool at the body,
//
//     c_n ≥ 0,  λ_n ≥ 0,  c_n λ_n = 0        |λ_t| ≤ μ λ_n,  c_t = −s λ_t with s ≥ 0, s = 0 where it sticks
//
// Held sites are eliminated exactly (the capacitance matrix algorithm by Cholesky); the others are found by
// block Gauss–Seidel with an exact solution at each site, finished by Newton steps on the set that it found.
// [SFEM; Alart, Curnier 1991 for the equations of the Newton steps]
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::contact {

enum class SiteState : std::uint8_t { kOpen, kStick, kSlip, kHeld };

/// One site alone, in a frame whose first axis is the normal: c = b + D λ with D its own block of C, and what
/// follows from D. The 2×2 matrix S = D_tt − D_tn D_nt / D_nn is the compliance across the normal while c_n =
/// 0.
struct SiteLaw {
  Mat3d axes;        // normal, two tangents
  Mat3d d, inverse;  // D [m/N] and D⁻¹
  double s[2];       // eigenvalues of S [m/N]
  double axis[2];    // in the tangents, the first eigenvector of S
  double slip = 0;   // α = |c_t|/|λ_t| of the last time it slid, to begin with [m/N]
};

/// Everything is allocated by make_coulomb; `count` and `held` may change from solution to solution.
struct FrictionalContactProblem {
  int count = 0, held = 0;            // sites; the first `held` of them are held
  int stride = 0;                     // numbers between columns of C, a multiple of 8
  aligned_vector<double> compliance;  // C, 3·count square, column-major, the blocks on and below the diagonal
                                      // [m/N]; overwritten
  aligned_vector<double> separation;  // b before, c after; three a site [m]
  std::vector<double> force;          // λ: a guess before, the answer after; three a site [N]
  std::vector<Vec3d> normal;          // unit, from the tool at the body
  std::vector<double> friction;       // μ [1]
  std::vector<SiteState> state;       // of the answer

  // Of use within a solution only.
  std::vector<SiteLaw> laws;
  std::vector<double> saved_force;
  aligned_vector<double> newton_matrix;  // column-major, the same stride
  aligned_vector<double> newton_column;
  std::vector<double> newton_rhs;
  std::vector<int> newton_row;  // first unknown of each site; -1 = none
};

/// With room for `capacity` sites.
FrictionalContactProblem make_frictional_contact_problem(int capacity);

struct FrictionalContactParams {
  int sweeps = 120;         // at most
  int newton_steps = 12;    // at most
  double tolerance = 1e-6;  // see CoulombReport::residual
};

struct FrictionalContactReport {
  int sweeps = 0, newton_steps = 0;
  // The largest change that its own exact solution still makes to a site's force, relative to the largest
  // force that one site alone would need [1].
  double residual = 0;
  bool converged = false;
};

/// The same bits for the same input; no allocation.
FrictionalContactReport solve(FrictionalContactProblem& problem, const FrictionalContactParams& params = {});

/// One site alone: the force λ at which c = b + D λ obeys the conditions, in the site's frame.
struct SiteSolution {
  Vec3d force;
  SiteState state = SiteState::kOpen;
};
/// The block D, symmetric and positive definite, in the frame of `axes`.
SiteLaw make_law(const Mat3d& axes, const Mat3d& d);
SiteSolution solve_site(SiteLaw& law, Vec3d b, double friction);

}  // namespace turgor::contact
