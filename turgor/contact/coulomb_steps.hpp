// Internals shared by the files of the contact solver: access to separations and forces, and the Newton step.
// During a solution all vectors are in the frames of their sites.
#pragma once

#include "turgor/contact/coulomb.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

/// Number of entries that one pass of a column loop processes. Columns are padded with zeros to a multiple of
/// it.
constexpr int kLanes = 8;
inline int padded(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

template <class Numbers>
Vec3d read_site(const Numbers& v, int site) {
  TURGOR_CHECK(site >= 0 && is_index(3 * site + 2, v.size()), "a contact site is within the storage");
  const double* p = &v[std::size_t(3 * site)];
  return {p[0], p[1], p[2]};
}
template <class Numbers>
void write_site(Vec3d value, int site, Numbers& v) {
  TURGOR_CHECK(site >= 0 && is_index(3 * site + 2, v.size()), "a contact site is within the storage");
  double* p = &v[std::size_t(3 * site)];
  p[0] = value.x, p[1] = value.y, p[2] = value.z;
}

inline double* column(FrictionalContactProblem& p, int j) {
  return &p.compliance[std::size_t(j) * std::size_t(p.stride)];
}
inline const double* column(const FrictionalContactProblem& p, int j) {
  return &p.compliance[std::size_t(j) * std::size_t(p.stride)];
}

/// c += C_i Δλ at all sites that are not held.
inline void add_separation(FrictionalContactProblem& p, int site, Vec3d change) {
  TURGOR_CHECK(site >= 0 && site < p.count, "a force acts on a site of the problem");
  const double *a = column(p, 3 * site), *b = column(p, 3 * site + 1), *c = column(p, 3 * site + 2);
  double* s = p.separation.data();
  for (int i = 0, end = padded(3 * p.count); i < end; i += kLanes) {
    TURGOR_LANES
    for (int q = i; q < i + kLanes; q++) s[q] += a[q] * change.x + b[q] * change.y + c[q] * change.z;
  }
}

/// λ_i += Δλ and c += C_i Δλ.
inline void add_force(FrictionalContactProblem& p, int site, Vec3d change) {
  double* f = &p.force[std::size_t(3 * site)];
  f[0] += change.x, f[1] += change.y, f[2] += change.z;
  add_separation(p, site, change);
}

/// One Newton step for all sites that bear force, with their present states as active set. Returns false and
/// changes nothing if its matrix is singular.
bool newton_step(FrictionalContactProblem& problem);

}  // namespace turgor::contact
