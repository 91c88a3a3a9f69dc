// Newton steps on the equations of the sites that bear force. Unknowns are forces in the frames of their
// sites. A sticking site obeys c = 0. A sliding site obeys
//
//     c_n = 0,    λ_t + μ λ_n d = 0,    d = w/|w|,    w = c_t − ρ λ_t
//
// with its own tangential compliance ρ. In the solution d is the direction of slip; next to sticking, where
// c_t is small, w changes less than c_t. [Alart, Curnier 1991] With e across d, the force along d follows
// from the normal force, δλ_d = −(λ_d + μ λ_n) − μ δλ_n. Two unknowns remain, δλ_n and δλ_e:
//
//     c_n + δc_n = 0,    (ρ − τ ρ) δλ_e + τ e·δc_t = −ρ λ_e,    τ = ρ μ λ_n/|w|
#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb_steps.hpp"
#include "turgor/contact/dense_system.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Unknowns and coefficients of a site, from its present state, separation and force.
NewtonSite newton_site(const FrictionalContactProblem& p, int i, int row) {
  const SiteState state = p.state[std::size_t(i)];
  if (state == SiteState::kOpen) return {};
  const double friction = p.friction[std::size_t(i)];
  if (friction <= 0) return {.row = row, .unknowns = 1};
  if (state == SiteState::kStick) return {.row = row, .unknowns = 3};
  NewtonSite site{.row = row, .unknowns = 2};
  const Vec3d c = read_site(p.separation, i), f = read_site(p.force, i);
  const SiteCompliance& law = p.laws[std::size_t(i)];
  site.compliance = (law.s[0] + law.s[1]) / 2;
  const double y = c.y - site.compliance * f.y, z = c.z - site.compliance * f.z;
  const double length = std::sqrt(y * y + z * z);
  TURGOR_CHECK(site.compliance > 0, "the compliance of a contact site is positive");
  if (length > 0) {
    site.d[0] = y / length, site.d[1] = z / length, site.friction = friction;
    // inside of the cone, the site is about to stick
    site.turn = std::min(1.0, site.compliance * friction * f.x / length);
  }
  site.along = -(site.d[0] * f.y + site.d[1] * f.z + site.friction * f.x);
  return site;
}

/// Component across the slip of a site's tangential vector.
double across(const NewtonSite& site, const double* v) { return site.d[0] * v[2] - site.d[1] * v[1]; }

/// Describes all sites and returns the number of unknowns.
int number_unknowns(FrictionalContactProblem& p) {
  int count = 0;
  for (int i = p.held; i < p.count; i++) {
    p.newton_sites[std::size_t(i)] = newton_site(p, i, count);
    count += p.newton_sites[std::size_t(i)].unknowns;
  }
  return count;
}

/// Rows of the equations of all sites from the separations that a unit of one unknown causes.
void fill_column(const FrictionalContactProblem& p, const double* separation, const DenseSystem& s,
                 double* target) {
  for (int i = p.held; i < p.count; i++) {
    const NewtonSite& site = p.newton_sites[std::size_t(i)];
    const double* c = separation + 3 * i;
    if (site.unknowns == 0) continue;
    target[site.row] = c[0];
    if (site.unknowns == 2) target[site.row + 1] = site.turn * across(site, c);
    if (site.unknowns == 3) target[site.row + 1] = c[1], target[site.row + 2] = c[2];
  }
  std::fill(target + s.n, target + padded(s.n), 0.0);
}

/// Columns of a sliding site. Adds the separations of its known change along the slip to `known`.
void fill_sliding(const FrictionalContactProblem& p, int j, const DenseSystem& s, double* known) {
  const NewtonSite& site = p.newton_sites[std::size_t(j)];
  const double *n = column(p, 3 * j), *y = column(p, 3 * j + 1), *z = column(p, 3 * j + 2);
  double *of_normal = s.factors, *of_across = of_normal + s.stride;
  const double dy = site.d[0], dz = site.d[1], friction = site.friction, change = site.along;
  TURGOR_LANES
  for (int i = 0; i < padded(3 * p.count); i++) {
    const double along = dy * y[i] + dz * z[i];
    of_normal[i] = n[i] - friction * along;
    of_across[i] = dy * z[i] - dz * y[i];
    known[i] += change * along;
  }
  fill_column(p, of_normal, s, s.column(site.row));
  fill_column(p, of_across, s, s.column(site.row + 1));
  s.column(site.row + 1)[site.row + 1] += site.compliance * (1 - site.turn);
}

/// Fills the matrix. Returns the changes of the separations by the known changes along the slips.
const double* fill_matrix(const FrictionalContactProblem& p, const DenseSystem& s) {
  double* known = s.factors + 2 * s.stride;
  std::fill_n(known, padded(3 * p.count), 0.0);
  for (int j = p.held; j < p.count; j++) {
    const NewtonSite& site = p.newton_sites[std::size_t(j)];
    if (site.unknowns == 2)
      fill_sliding(p, j, s, known);
    else
      for (int k = 0; k < site.unknowns; k++) fill_column(p, column(p, 3 * j + k), s, s.column(site.row + k));
  }
  return known;
}

/// Residuals of all equations after the known changes.
void fill_rhs(const FrictionalContactProblem& p, const double* known, const DenseSystem& s) {
  fill_column(p, known, s, s.rhs);
  for (int i = p.held; i < p.count; i++) {
    const NewtonSite& site = p.newton_sites[std::size_t(i)];
    if (site.unknowns == 0) continue;
    s.rhs[site.row] += p.separation[std::size_t(3 * i)];
    if (site.unknowns == 2)
      s.rhs[site.row + 1] += site.compliance * across(site, &p.force[std::size_t(3 * i)]);
    for (int k = 1; site.unknowns == 3 && k < 3; k++)
      s.rhs[site.row + k] += p.separation[std::size_t(3 * i + k)];
  }
  for (int i = 0; i < s.n; i++) s.rhs[i] = -s.rhs[i];
}

/// Change of a site's force from the solution.
Vec3d change_of(const NewtonSite& site, const double* solution) {
  const double* x = solution + site.row;
  if (site.unknowns == 1) return {x[0], 0, 0};
  if (site.unknowns == 3) return {x[0], x[1], x[2]};
  const double along = site.along - site.friction * x[0];
  // a site without slip direction loses its tangential force
  return {x[0], site.d[0] * along - site.d[1] * x[1], site.d[1] * along + site.d[0] * x[1]};
}

}  // namespace

bool newton_step(FrictionalContactProblem& p) {
  // matrix and right-hand side
  const int n = number_unknowns(p);
  const DenseSystem s{p.newton_matrix.data(), p.newton_rhs.data(), p.newton_columns.data(), n, p.stride};
  fill_rhs(p, fill_matrix(p, s), s);
  // solve and add the change of the forces
  if (!solve_in_place(s)) return false;
  for (int i = p.held; i < p.count; i++) {
    const NewtonSite& site = p.newton_sites[std::size_t(i)];
    if (site.unknowns > 0) add_force(p, i, change_of(site, s.rhs));
  }
  return true;
}

}  // namespace turgor::contact
