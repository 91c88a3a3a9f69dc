// Forces between bodies of finite elements: ties (springs between points of two surfaces) and contact with
// friction, solved together. Unknown is one force λ_s for every tie or contact site, which acts on its point
// a and, reversed, on its point b. Both bodies yield, so that the compliances add up:
//
//     x(a_s) − x(b_s) = b_s + Σ_t C_st λ_t        C_st = Σ ± w_i w_j Ξ(i, j) over vertices i, j of one body
//
// A tie has the stiffness k and the slack s. With d = x(a) − x(b) minus its value at rest,
//
//     λ = −k max(0, |d| − s) d / |d|
//
// These are the conditions of a convex minimum, ½ λᵀ C λ + Σ ½ k max(0, |d| − s)². Newton steps find it. In
// each, a taut tie is a held site of the frictional contact problem (coulomb.hpp) with the compliance of its
// tangent.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/viscosity.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::contact {

/// A point of a body's surface, or a position in space that does not move.
struct SurfacePoint {
  int body = -1;            // index of its body; -1 = space
  Int3 vertex{-1, -1, -1};  // of the body's mesh, -1 = unused
  Vec3d weight;             // of each, sum 1
  Vec3d rest;               // position at rest [m]
};

/// A body as the coupling sees it.
struct CoupledBody {
  const sfem::Model* model = nullptr;  // has a dense store of Green's functions; null = takes no part
  double stiffness_scale = 1;          // divides displacements by forces
  std::vector<Vec3d> free;             // displacement of every vertex without forces of the coupling [m]
};

/// A spring between two points that pulls and pushes. It breaks above its strength.
struct Tie {
  SurfacePoint a, b;
  double stiffness = 0;  // [N/m]
  double slack = 0;      // [m]
  double strength = 0;   // 0 = does not break [N]
  bool broken = false;
  Vec3d force;  // on a [N]
};

/// A point of one surface that may touch another one.
struct PairSite {
  SurfacePoint a, b;    // the vertex, and the nearest point of the other surface when it was found
  SurfacePoint anchor;  // point of the other surface to which friction holds it
  Vec3d slip;           // part of x(a) − x(anchor) that friction does not resist [m]
  Vec3d normal;         // unit, from b toward a
  double distance = 0;  // along the normal before this solution, reduced by the distance to be kept [m]
  Vec3d found;          // x(a) − x(b) when it was found [m]
  double friction = 0;  // Coulomb's μ [1]
  Vec3d force;          // on a [N]
  SiteState state = SiteState::kOpen;
};

struct CouplingReport {
  int solves = 0;         // of the contact problem
  int broken = 0;         // ties that broke
  bool converged = true;  // false: the forces are those of the last solution
};

/// Displacement of a surface point; zero for a position in space [m].
Vec3d displacement_of(const SurfacePoint& point, std::span<const Vec3d> displacement);
/// Change of a tie's x(a) − x(b) from its value at rest, without forces of the coupling [m].
Vec3d free_stretch(std::span<const CoupledBody> bodies, const Tie& tie);

/// Solves for the forces of all ties and sites. Ties whose force exceeds their strength break, the most
/// overloaded one first. The same bits on any number of threads.
CouplingReport solve_coupling(const Exec& exec, std::span<const CoupledBody> bodies, std::span<Tie> ties,
                              std::span<PairSite> sites);

/// Forces of ties and sites on the vertices of one body, ascending.
std::vector<VertexForce> forces_on(int body, std::span<const Tie> ties, std::span<const PairSite> sites);

}  // namespace turgor::contact
