#include "turgor/sim/bodies/cloth/cloth_load.hpp"

#include <algorithm>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor {

void relax_toward(const ClothForces& forces, ClothLoad& load) {
  TURGOR_CHECK(load.relaxation > 0 && load.relaxation <= 1, "a relaxation is above 0 and at most 1");
  constexpr double kForgotten = 1e-6;  // smaller forces are dropped, relative to the largest
  std::map<int, Vec3d> force;
  for (const auto& [vertex, f] : load.force) force[vertex] += f * (1 - load.relaxation);
  for (const auto& [vertex, f] : forces.force) force[vertex] += f * load.relaxation;
  double largest = 0;
  for (const auto& [vertex, f] : load.force) largest = std::max(largest, norm(f));
  for (const auto& [vertex, f] : forces.force) largest = std::max(largest, norm(f));
  load.force.clear();
  for (const auto& [vertex, f] : force)
    if (norm(f) > kForgotten * largest) load.force.push_back({vertex, f});
}

std::vector<contact::VertexForce> forces_along(const ClothLoad& load, int axis) {
  TURGOR_CHECK(axis >= 0 && axis < 3, "a force acts along one of three axes");
  std::vector<contact::VertexForce> along;
  for (const auto& [vertex, f] : load.force) {
    along.push_back({vertex, {}});
    along.back().force[axis] = norm(f);
  }
  return along;
}

// Relaxation by a stability bound. The cloth's mass m is accelerated by the body's displacement C f / h² per
// force f. One frame later the force returns κ = m C / h² times as large. With relaxation p, f(n+1) = m g − κ
// (f(n) − 2 f(n−1) + f(n−2)) is stable for 4 p κ < 2 − p; half of this bound is used. Parallel forces bound
// C: no other load of the same magnitudes displaces a vertex much farther.
void choose_relaxation(double mass, double dt, ClothLoad& load) {
  TURGOR_CHECK(is_step_length(dt) && mass >= 0, "cloth has a mass and steps of positive length");
  if (load.compliance.x == 0 || load.compliance.y == 0 || load.compliance.z == 0) return;
  const double gain = mass * std::max({load.compliance.x, load.compliance.y, load.compliance.z}) / (dt * dt);
  load.relaxation = std::min(1.0, 1 / (4 * gain + 0.5));
  TURGOR_CHECK(load.relaxation > 0 && load.relaxation <= 1, "a relaxation is above 0 and at most 1");
}

double sum_of_norms(const ClothLoad& load) {
  double sum = 0;
  for (const auto& [vertex, f] : load.force) sum += norm(f);
  return sum;
}

Vec3d total_force(const ClothLoad& load) {
  Vec3d sum;
  for (const auto& [vertex, f] : load.force) sum += f;
  return sum;
}

}  // namespace turgor
