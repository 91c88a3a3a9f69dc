// Lattices that nothing fixes, among the bodies that they touch and hold.
//
// Forces of the coupling with finite elements and rigid bodies (couple.cpp) act on a lattice from the next
// frame on, relaxed. A free body that feels a part of them late is driven by the rest. Its motion as a whole
// is therefore solved together with the forces, as that of a rigid body with its mass m and inertia J: over a
// frame of h seconds a point at the arm r moves by
//
//     h (v + ω × r) + h² (g + F/m + J⁻¹ T × r)
//
// The relaxed forces deform it. What they leave out of F and T becomes an acceleration of the whole body,
// which deforms nothing (press_body). Momentum is exact then.
#pragma once

#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/sim/organs/coupling.hpp"

namespace turgor {

struct LatticeBody;

/// True for a lattice whose motion as a whole is solved with the forces of the coupling: a free one without
/// needles that no contact or attachment in the sweeps of a lattice, and no cloth, holds.
bool moves_whole(const World& world, const CoupledSupport& support);

/// True if nothing but loads and contacts with other free lattices acts on a lattice, nor on those.
bool is_among_free_lattices(const World& world, const LatticeBody& body);

/// Adds the motion of a lattice as a whole in the next frame to displacements, under the present forces of
/// its tools. `x`: present positions of the vertices of the support.
contact::SupportInertia move_ahead(const World& world, const CoupledSupport& support,
                                   const std::vector<Vec3d>& x, std::vector<Vec3d>& displacement);

/// Sets the start of a step, and how its momentum is balanced.
void set_free_motion(const World& world, const LatticeBody& body, lattice::Inputs& inputs);

/// Records the unbalanced force of a step of a free lattice with one contact, in which all of it is.
void record_balance(World& world, const LatticeBody& body, const lattice::StepReport& done);

}  // namespace turgor
