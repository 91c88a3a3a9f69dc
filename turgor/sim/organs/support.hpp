// Lattices and bodies of chains in the coupling of bodies: supports. Their solvers are not part of the system
// of all forces. A lattice is where its last step left it, under the forces f' that it bore there: those of
// earlier frames, relaxed. The compliance of its sites is an estimate S. With the compliance C of the other
// body, a site has the separation
//
//     g + C f + S (f - f')
//
// At rest f = f' and the estimate has no effect; until then it spreads the load over the sites. An estimate
// that is too soft, or a force f' that the lattice does not bear yet, would make forces lag behind the motion
// of a body, and drive it: a ball would begin to roll. The forces act from the next frame on.
#pragma once

#include <span>
#include <vector>

#include "turgor/sim/organs/coupling.hpp"

namespace turgor {

struct RigidBody;
struct Scene;

/// Adds a support for every lattice and body of chains in attachments and contacts.
void add_supports(const Exec& exec, const Scene& scene, World& world);

/// Number of the first support, and of the first tool of the world, in attachments and contacts.
int first_support(const World& world);
int first_tool(const World& world);
/// The rigid body of a number, or null.
const RigidBody* rigid_body(const World& world, int index);

/// Triangles of a support near the vertices of another body.
std::vector<Int3> triangles_near(const CoupledSupport& support, const std::vector<Vec3d>& x,
                                 const std::vector<Vec3d>& other, double reach);

/// Compliance of a site of a support: that of a node of its grid, 1/(E h) [m/N].
double node_softness(const World& world, const CoupledSupport& support, int vertex);

/// Sets the compliance of the sites of supports, and moves the sites by the forces that these bear.
void remember_supports(World& world);
/// Moves the sites back after the solution, and updates the forces that supports will bear.
void forget_supports(World& world);

/// Forces on supports, and the stiffness of what they touch: that of attachments and of the other body in
/// series.
void load_supports(World& world, std::span<const contact::Tie> ties,
                   std::span<const contact::PairSite> sites);

}  // namespace turgor
