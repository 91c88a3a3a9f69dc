#include "turgor/models/lattice/mechanics/point_springs.hpp"

#include <algorithm>

namespace turgor::lattice {

void make_terms(PointSprings& springs) {
  springs.terms.clear();
  for (std::size_t s = 0; s < springs.all.size(); s++) {
    const EmbeddedPoint& point = springs.all[s].at;
    for (std::size_t c = 0; c < 8; c++)
      if (point.weight[c] != 0) springs.terms.push_back({point.corner[c], int(s), point.weight[c]});
  }
  std::stable_sort(springs.terms.begin(), springs.terms.end(),
                   [](const PointSpringTerm& a, const PointSpringTerm& b) { return a.corner < b.corner; });
}

std::span<const PointSpringTerm> terms_of(const PointSprings* springs, int corner, int count) {
  if (springs == nullptr || springs->terms.empty()) return {};
  const auto before = [](const PointSpringTerm& term, int c) { return term.corner < c; };
  const auto begin = std::lower_bound(springs->terms.begin(), springs->terms.end(), corner, before);
  return {begin, std::lower_bound(begin, springs->terms.end(), corner + count, before)};
}

Vec3 displacement(const EmbeddedPoint& point, const Motion& motion) {
  const int slots = int(motion.u.x.size());
  return displacement(point, [&](int corner) {
    if (corner < slots) return motion.u[std::size_t(corner)];
    const VirtualNodeDisplacement& u = motion.virtual_u[std::size_t(corner - slots)];
    return Vec3{u.x, u.y, u.z};
  });
}

double spring_energy(const PointSpring& spring, Vec3 u) {
  const Vec3 d = u - spring.target;
  return 0.5 * dot(Vec3d(d), Vec3d(spring.stiffness * d)) - dot(Vec3d(spring.force), Vec3d(u));
}

}  // namespace turgor::lattice
