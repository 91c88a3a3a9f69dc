// What the parts of the contact solver share: access to its numbers, which are in the frames of the sites
// while it works, and the Newton step.
#pragma once

#include "turgor/contact/coulomb.hpp"

namespace turgor::contact {

/// Loops over columns run in whole lanes; what is behind the last unknown is zero.
constexpr int kLanes = 8;
inline int padded(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

template <class Numbers>
Vec3d read_site(const Numbers& v, int site) {
  const double* p = &v[std::size_t(3 * site)];
  return {p[0], p[1], p[2]};
}
template <class Numbers>
void write_site(Vec3d value, int site, Numbers& v) {
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
  const double *a = column(p, 3 * site), *b = column(p, 3 * site + 1), *c = column(p, 3 * site + 2);
  double* s = p.separation.data();
  for (int i = 0, end = padded(3 * p.count); i < end; i += kLanes) {
    TURGOR_LANES
    for (int q = i; q < i + kLanes; q++) s[q] += a[q] * change.x + b[q] * change.y + c[q] * change.z;
  }
}

/// λ_i += Δλ, and what follows from it.
inline void add_force(FrictionalContactProblem& p, int site, Vec3d change) {
  double* f = &p.force[std::size_t(3 * site)];
  f[0] += change.x, f[1] += change.y, f[2] += change.z;
  add_separation(p, site, change);
}

/// One Newton step of all sites that bear force, from their present states. False, and nothing is changed,
/// when its matrix is singular.
bool newton_step(FrictionalContactProblem& problem);

}  // namespace turgor::contact
