// Lattices and bodies of chains in the coupling of bodies: supports. Their solvers are not part of the system
// of all forces. A support is where its last step left it, and the compliance of its sites is an estimate S:
// with the forces f' of the latest frame and the compliance C of the other body, a site has the separation
//
//     g + C f + S (f - f')
//
// At rest f = f' and the estimate has no effect; until then it spreads the load over the sites. The forces
// act on the support from the next frame on.
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

/// Forces of the sites of each contact before a solution.
using SupportMemory = std::vector<std::vector<Vec3d>>;
/// Sets the compliance of the sites of supports, and moves the sites by the forces of the latest frame.
SupportMemory remember_supports(World& world);
/// Moves the sites back after the solution.
void forget_supports(const SupportMemory& memory, World& world);

/// Forces on supports, and the stiffness of what they touch: that of attachments and of the other body in
/// series.
void load_supports(World& world, std::span<const contact::Tie> ties,
                   std::span<const contact::PairSite> sites);

}  // namespace turgor
