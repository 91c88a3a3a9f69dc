// Obstacles that the cloth moves: free rigid bodies, and free bodies of finite elements as far as they move
// as a whole. Six velocities q of such a body are unknowns of the linear system of the cloth, so that a light
// sheet bears a heavy body without a delay. With the stiffness K of a contact, the velocity change u of its
// cloth and the motion J q of the body's surface there,
//
//   P = load − K (u − J q),     M q = −Σ Jᵀ P − L.
//
// M is the body's inertia, and L the load that its predicted velocity has already. The body is eliminated:
// with S = Σ Jᵀ (load − K u) and B = Σ Jᵀ K J, q = −(M + B)⁻¹ (S + L). The matrix of the cloth stays
// symmetric and positive definite.
#pragma once

#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// −K u of a contact.
inline Vec3 resisting_impulse(const Contact& c, const ImplicitContact& terms, Vec3 u) {
  return -u * terms.tangential_stiffness -
         c.normal * ((terms.normal_stiffness - terms.tangential_stiffness) * dot(u, c.normal));
}

/// Lists the free obstacles of a step, and the arms of their contacts. Implicit contacts must be found.
void find_free_obstacles(const Inputs& inputs, State& state);
/// Factors M + B for the present terms of the contacts.
void factor_free_obstacles(State& state);
/// Adds K J q to Contact::impulse_delta, which has load − K u; without loads, −K u.
void yield_free_obstacles(bool with_loads, State& state);
/// Adds the motion of the latest solution to the obstacles and to the velocities of their contacts.
void move_free_obstacles(State& state);

/// Total impulse on a free obstacle in the latest step [N s], and its moment about the obstacle's center
/// [N m s].
ObstacleLoad free_obstacle_load(const State& state, int obstacle);

}  // namespace turgor::cloth
