// Viscoelasticity without inertia: one Prony pair for the whole body. A fast press feels (1 + p) times the
// long-term stiffness K, a hold relaxes to K with the time τ:
//
//     f = K u + p K (u − v)        dv/dt = (u − v) / τ
//
// Implicit Euler over a tick, a = dt/τ, p' = p/(1 + a), turns this into the elastic answer of a stiffer body:
//
//     u = (Ξ f + p' v)/(1 + p')        v⁺ = (v + a u)/(1 + a)
//
// so Green's functions of the elastic body are all that is needed, and v = Ξ φ, the force that the material
// still remembers, φ⁺ = (φ + a (f + p' φ)/(1 + p'))/(1 + a). v is kept at the points of the patch, φ because
// a new patch needs it.
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

/// The numbers of one tick.
struct ViscousTick {
  double a = 0, p = 0;  // dt/τ and p' above
};
ViscousTick viscous_tick(const Viscosity& viscosity, double dt);

/// A force on a coarse vertex.
struct VertexForce {
  int vertex = 0;
  Vec3d force;  // [N]
};

/// What the material remembers. Empty when it is elastic.
struct ViscousHistory {
  std::vector<Vec3d> v;          // of each point of the patch [m]
  std::vector<Vec3d> phi;        // on each point, since the patch was taken [N]
  std::vector<VertexForce> far;  // what was remembered before that, on coarse vertices
  double far_fraction = 1;       // of `far` that is left [1]
};

/// After a tick in which the points moved to u under the forces f.
void remember(const ViscousTick& tick, std::span<const Vec3d> u, std::span<const Vec3d> f,
              ViscousHistory& history);

/// Everything that is remembered, as the coarse body feels it, ascending by vertex.
std::vector<VertexForce> coarse_history(const ViscousHistory& history, const sfem::Patch& patch);

/// Displacements of a patch's points by forces on coarse vertices, through the Green's functions [m].
std::vector<Vec3d> displacements(const sfem::Model& model, std::span<const VertexForce> forces,
                                 const sfem::Patch& patch);

}  // namespace turgor::contact
