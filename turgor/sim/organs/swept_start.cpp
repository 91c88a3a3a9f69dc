#include "turgor/sim/organs/swept_start.hpp"

#include <algorithm>

#include "turgor/sim/organs/swept_body.hpp"

namespace turgor {

namespace {

/// Velocity of the center of mass of a lattice that nothing fixes, lattice frame [m/s].
Vec3d center_velocity(const LatticeBody& body, double mass) {
  const lattice::Motion& motion = body.state->motion;
  const auto& inverse_mass = body.model.anatomy.inverse_mass;
  Vec3d momentum;
  for (std::size_t slot = 0; slot < inverse_mass.size(); slot++)
    if (inverse_mass[slot] > 0) momentum += Vec3d(motion.v[slot]) / double(inverse_mass[slot]);
  return momentum / mass;
}

}  // namespace

void SweptForces::add(Vec3d force, Vec3d motion) {
  sum += force, magnitudes += norm(force), ahead += motion * norm(force);
}

Vec3d start_acceleration(const LatticeBody& body, const SweptForces& forces, Vec3d tools, Vec3d gravity,
                         double dt) {
  if (forces.free_mass == 0) return {};
  const Vec3d by_tools = tools / forces.free_mass;
  if (!(norm(forces.sum) > 0)) return by_tools;
  // limit along the force
  const Vec3d to = normalized(forces.sum),
              approach = forces.ahead / (forces.magnitudes * dt) - center_velocity(body, forces.free_mass),
              rest = transposed(patient_axes(body)) * gravity + by_tools;
  const double most = std::max(0.0, dot(approach, to)) / dt - dot(rest, to);
  const Vec3d along = to * std::min(norm(forces.sum) / forces.free_mass, std::max(0.0, most));
  // limit across it
  const Vec3d stopped = approach / dt - rest, across = stopped - to * dot(stopped, to);
  const double friction = forces.friction / forces.free_mass, wanted = norm(across);
  return by_tools + along + (wanted > friction ? across * (friction / wanted) : across);
}

}  // namespace turgor
