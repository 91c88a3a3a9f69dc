// Viscoelasticity without inertia: a Prony series of up to three pairs for the whole body (models/prony.hpp).
// The body has (1 + Σ pᵢ) times its long-term stiffness K in a fast press. In a press of constant depth the
// stiffness relaxes to K with the time constants τᵢ:
//
//     f = K u + Σ pᵢ K (u − vᵢ)        dvᵢ/dt = (u − vᵢ) / τᵢ
//
// Implicit Euler over a tick, with aᵢ = dt/τᵢ, pᵢ' = pᵢ/(1 + aᵢ) and P = Σ pᵢ', gives the elastic response of
// a stiffer body:
//
//     u = (Ξ f + Σ pᵢ' vᵢ)/(1 + P)        vᵢ⁺ = (vᵢ + aᵢ u)/(1 + aᵢ)
//
// The elastic Green's functions Ξ = K⁻¹ are therefore sufficient. The memory vᵢ is the displacement Ξ φᵢ
// under a memory force φᵢ:
//
//     φᵢ⁺ = (φᵢ + aᵢ (f + Σ pⱼ' φⱼ)/(1 + P))/(1 + aᵢ)
//
// vᵢ is stored at the points of the patch. φᵢ is stored too, because it gives vᵢ on a new patch.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/models/prony.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

/// Coefficients of one tick.
struct ViscousTick {
  int count = 0;                                 // pairs in use; 0 = elastic
  std::array<double, kMostPronyPairs> a{}, p{};  // aᵢ and pᵢ' above
  double total = 0;                              // P
};
ViscousTick viscous_tick(const Prony& viscosity, double dt);

/// A force on a coarse vertex.
struct VertexForce {
  int vertex = 0;
  Vec3d force;  // [N]
};

/// Memory of one pair.
struct PairHistory {
  std::vector<Vec3d> v;    // v of each point of the patch [m]
  std::vector<Vec3d> phi;  // φ on each point, accumulated since the patch was taken [N]
  std::vector<VertexForce>
      far;  // φ of earlier patches on coarse vertices, as it was when the patch was taken
};

/// Viscous memory. Empty for elastic material; each pair in use has its own.
struct ViscousHistory {
  std::array<PairHistory, kMostPronyPairs> pairs;
  int count = 0;  // pairs in use
  // Present φᵢ on coarse vertices: Σ far_factor[i][j] · far of pair j, those out of use included. The matrix
  // is the identity when a patch is taken.
  std::array<std::array<double, kMostPronyPairs>, kMostPronyPairs> far_factor = kNoDecay;

  static constexpr std::array<std::array<double, kMostPronyPairs>, kMostPronyPairs> kNoDecay{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// Displacement Σ pᵢ'/(1 + P) vᵢ of a point without any force of this tick [m].
Vec3d remembered_displacement(const ViscousTick& tick, const ViscousHistory& history, std::size_t point);

/// Updates the memory after a tick in which the points moved to u under the forces f.
void remember(const ViscousTick& tick, std::span<const Vec3d> u, std::span<const Vec3d> f,
              ViscousHistory& history);

/// Changes the pairs between two ticks. Pairs that stay in use keep their memory. A pair that comes into use
/// is relaxed: its v is the displacement u of the last tick, so that it adds no force yet. `f` are the forces
/// of that tick. Allocates only beyond the reserved size.
void change_pairs(const Prony& before, const Prony& after, std::span<const Vec3d> u, std::span<const Vec3d> f,
                  ViscousHistory& history);

/// Total memory force φ of a pair on coarse vertices, ascending.
std::vector<VertexForce> coarse_history(const ViscousHistory& history, int pair, const sfem::Patch& patch);

/// Displacements of a patch's points by forces on coarse vertices, from the Green's functions [m].
std::vector<Vec3d> displacements(const sfem::Model& model, std::span<const VertexForce> forces,
                                 const sfem::Patch& patch);

}  // namespace turgor::contact
