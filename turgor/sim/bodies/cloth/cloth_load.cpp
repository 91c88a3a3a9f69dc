#include "turgor/sim/bodies/cloth/cloth_load.hpp"

#include <algorithm>
#include <map>

namespace turgor {

void take_over(const ClothPush& push, ClothLoad& load) {
  constexpr double kForgotten = 1e-6;  // of the largest force of a vertex
  std::map<int, Vec3d> force;
  for (const auto& [vertex, f] : load.force) force[vertex] += f * (1 - load.part);
  for (const auto& [vertex, f] : push.force) force[vertex] += f * load.part;
  double largest = 0;
  for (const auto& [vertex, f] : load.force) largest = std::max(largest, norm(f));
  for (const auto& [vertex, f] : push.force) largest = std::max(largest, norm(f));
  load.force.clear();
  for (const auto& [vertex, f] : force)
    if (norm(f) > kForgotten * largest) load.force.push_back({vertex, f});
}

std::vector<contact::VertexForce> forces_along(const ClothLoad& load, int axis) {
  std::vector<contact::VertexForce> along;
  for (const auto& [vertex, f] : load.force) {
    along.push_back({vertex, {}});
    along.back().force[axis] = norm(f);
  }
  return along;
}

// The cloth's mass m is accelerated by what the body gave way, C f/h² of f: a frame later the force comes
// back κ = m C/h² times as large. With a part p taken over, f(n+1) = m g − κ (f(n) − 2 f(n−1) + f(n−2)) is
// stable while 4 p κ < 2 − p; half of that is used. Forces in one direction bound C: no other load of the
// same sizes moves a vertex much farther.
void choose_part(double mass, double dt, ClothLoad& load) {
  if (load.answer.x == 0 || load.answer.y == 0 || load.answer.z == 0) return;
  const double gain = mass * std::max({load.answer.x, load.answer.y, load.answer.z}) / (dt * dt);
  load.part = std::min(1.0, 1 / (4 * gain + 0.5));
}

double sum_of_sizes(const ClothLoad& load) {
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
