// Viscoelasticity without inertia: one Prony pair for the whole body. The body has (1 + p) times its
// long-term stiffness K in a fast press. In a press of constant depth the stiffness relaxes to K with the
// time constant τ:
//
//     f = K u + p K (u − v)        dv/dt = (u − v) / τ
//
// Implicit Euler over a tick, with a = dt/τ and p' = p/(1 + a), gives the elastic response of a stiffer body:
//
//     u = (Ξ f + p' v)/(1 + p')        v⁺ = (v + a u)/(1 + a)
//
// The elastic Green's functions Ξ = K⁻¹ are therefore sufficient. The memory v is the displacement Ξ φ under
// a memory force φ:
//
//     φ⁺ = (φ + a (f + p' φ)/(1 + p'))/(1 + a)
//
// v is stored at the points of the patch. φ is stored too, because it gives v on a new patch.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

struct Viscosity {
  double stiffening = 0;  // p; 0 = elastic [1]
  double time = 0.1;      // τ [s]
};

/// Coefficients of one tick.
struct ViscousTick {
  double a = 0, p = 0;  // dt/τ and p' above
};
ViscousTick viscous_tick(const Viscosity& viscosity, double dt);

/// A force on a coarse vertex.
struct VertexForce {
  int vertex = 0;
  Vec3d force;  // [N]
};

/// Viscous memory. Empty for elastic material.
struct ViscousHistory {
  std::vector<Vec3d> v;          // v of each point of the patch [m]
  std::vector<Vec3d> phi;        // φ on each point, accumulated since the patch was taken [N]
  std::vector<VertexForce> far;  // φ of earlier patches, on coarse vertices
  double far_fraction = 1;       // remaining fraction of `far` [1]
};

/// Updates the memory after a tick in which the points moved to u under the forces f.
void remember(const ViscousTick& tick, std::span<const Vec3d> u, std::span<const Vec3d> f,
              ViscousHistory& history);

/// Total memory force φ on coarse vertices, ascending.
std::vector<VertexForce> coarse_history(const ViscousHistory& history, const sfem::Patch& patch);

/// Displacements of a patch's points by forces on coarse vertices, from the Green's functions [m].
std::vector<Vec3d> displacements(const sfem::Model& model, std::span<const VertexForce> forces,
                                 const sfem::Patch& patch);

}  // namespace turgor::contact
