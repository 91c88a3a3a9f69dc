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

/// Everything is allocated by make_coulomb; `count` and `held` may change from solution to solution.
struct Coulomb {
  int count = 0, held = 0;  // sites; the first `held` of them are held
  int stride = 0;           // numbers between columns of C
  aligned_vector<double>
      compliance;                 // C, 3·count square, column-major [m/N]; overwritten when sites are held
  std::vector<Vec3d> separation;  // b before, c after [m]
  std::vector<Vec3d> normal;      // unit, from the tool at the body
  std::vector<double> friction;   // μ [1]
  std::vector<Vec3d> force;       // λ, a guess before [N]
  std::vector<SiteState> state;   // a guess is not needed

  aligned_vector<double> matrix, scratch;  // of a solution
  std::vector<double> local;
};

Coulomb make_coulomb(int capacity);

struct CoulombParams {
  int sweeps = 200;         // at most
  int newton = 20;          // steps, at most
  double tolerance = 1e-9;  // largest error of a condition, relative to the largest force
};

struct CoulombReport {
  int sweeps = 0, newton = 0;
  double residual = 0;  // largest change of a force by its own site's exact solution / largest force [1]
  bool converged = false;
};

/// Same bits for the same input, no allocation.
CoulombReport solve(Coulomb& problem, const CoulombParams& params = {});

/// One site alone: the force at which c = b + D λ obeys the conditions. D is symmetric positive definite, by
/// rows, in a frame whose first axis is the normal.
Vec3d solve_site(const double (&d)[9], Vec3d b, double friction);

}  // namespace turgor::contact
