// Contact with Coulomb friction on a capacitance matrix. A body has k contact sites. A tool presses on a site
// (unilateral, with friction) or holds it. The unknowns are the forces λ. They determine the separations
//
//     c = b + C λ        (three numbers per site; b: separations without contact forces)
//
// The conditions are c = 0 at held sites. At all other sites, with the normal n pointing from the tool toward
// the body,
//
//     c_n ≥ 0,  λ_n ≥ 0,  c_n λ_n = 0        |λ_t| ≤ μ λ_n,  c_t = −s λ_t with s ≥ 0, s = 0 where it sticks
//
// Held sites are eliminated exactly (the capacitance matrix algorithm by Cholesky). The other sites are
// solved by block Gauss–Seidel with an exact solution at each site. Newton steps on the active set that it
// finds complete the solution. [SFEM; Alart, Curnier 1991 for the equations of the Newton steps]
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::contact {

enum class SiteState : std::uint8_t { kOpen, kStick, kSlip, kHeld };

/// Compliance of one site in a frame whose first axis is the normal: c = b + D λ, with D the site's own block
/// of C. The 2×2 matrix S = D_tt − D_tn D_nt / D_nn is the tangential compliance while c_n = 0.
struct SiteCompliance {
  Mat3d axes;        // normal, two tangents
  Mat3d d, inverse;  // D [m/N] and D⁻¹
  double s[2];       // eigenvalues of S [m/N]
  double axis[2];    // first eigenvector of S, in coordinates of the two tangents
  double slip = 0;   // α = |c_t|/|λ_t| of the last sliding solution; initial guess of the next one [m/N]
};

/// Unknowns and coefficients of a site in a Newton step (coulomb_newton.cpp).
struct NewtonSite {
  int row = -1;           // its first unknown; -1 = none
  int unknowns = 0;       // 0 open, 1 without friction, 2 sliding, 3 sticking
  double d[2] = {1, 0};   // direction of slip
  double friction = 0;    // μ; 0 without a direction
  double along = 0;       // known change of the force along d [N]
  double compliance = 0;  // ρ [m/N]
  double turn = 0;        // τ [1]
};

/// All storage is allocated by make_frictional_contact_problem. `count` and `held` may change between
/// solutions.
struct FrictionalContactProblem {
  int count = 0, held = 0;            // number of sites; the first `held` of them are held
  int stride = 0;                     // numbers between columns of C, a multiple of 8
  aligned_vector<double> compliance;  // C, 3·count square, column-major, the blocks on and below the diagonal
                                      // [m/N]; overwritten
  aligned_vector<double> separation;  // input b, output c; three per site [m]
  std::vector<double> force;          // λ: input initial guess, output solution; three per site [N]
  std::vector<Vec3d> normal;          // unit, from the tool toward the body
  std::vector<double> friction;       // μ [1]
  std::vector<SiteState> state;       // of the solution

  // workspace of solve()
  std::vector<SiteCompliance> laws;
  std::vector<double> saved_force;
  aligned_vector<double> newton_matrix;   // column-major, the same stride
  aligned_vector<double> newton_columns;  // DenseSystem::kPanel of them
  aligned_vector<double> newton_rhs;
  std::vector<NewtonSite> newton_sites;
};

/// Allocates a problem for up to `capacity` sites.
FrictionalContactProblem make_frictional_contact_problem(int capacity);

struct FrictionalContactParams {
  int sweeps = 120;         // at most
  int newton_steps = 12;    // at most
  double tolerance = 1e-6;  // see FrictionalContactReport::residual
};

struct FrictionalContactReport {
  int sweeps = 0, newton_steps = 0;
  // Largest change of a site's force in the last sweep, relative to the largest force that any site would
  // need alone [1].
  double residual = 0;
  bool converged = false;
};

/// Solves the problem in place. The same input gives the same bits. Does not allocate.
FrictionalContactReport solve(FrictionalContactProblem& problem, const FrictionalContactParams& params = {});

/// Solution of one site in its own frame: the force λ for which c = b + D λ satisfies the conditions.
struct SiteSolution {
  Vec3d force;
  SiteState state = SiteState::kOpen;
};
/// Law of a site from its block D, symmetric and positive definite, in the frame of `axes`.
SiteCompliance make_law(const Mat3d& axes, const Mat3d& d);
SiteSolution solve_site(SiteCompliance& law, Vec3d b, double friction);

}  // namespace turgor::contact
