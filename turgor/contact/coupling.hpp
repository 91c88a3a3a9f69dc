// Forces between bodies of finite elements and rigid bodies: ties (springs between points of two surfaces)
// and contact with friction, solved together. Unknown is one force λ_s for every tie or contact site, which
// acts on its point a and, reversed, on its point b. Both bodies yield, so that the compliances add up:
//
//     x(a_s) − x(b_s) = b_s + Σ_t C_st λ_t        C_st = Σ ± w_i w_j Ξ(i, j) over vertices i, j of one body
//
// A point of a rigid body has the arm r from the center of mass. Over a frame of h seconds it yields to a
// force by its inertia, linearized around the last solution:
//
//     C_st = ± h² (I/m − [r_s]× J⁻¹ [r_t]×)
//
// A tie has the stiffness k and the slack s. With d = x(a) − x(b) minus its value at rest,
//
//     λ = −k max(0, |d| − s) d / |d|
//
// These are the conditions of a convex minimum, ½ λᵀ C λ + Σ ½ k max(0, |d| − s)². Newton steps find it. In
// each, a taut tie is a held site of the frictional contact problem (coulomb.hpp) with the compliance of its
// tangent.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/viscosity.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/geometry/pose.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::contact {

/// A point of a body's surface, or a position in space that does not move. A point of a rigid body is that of
/// its position at rest; the vertices only identify it.
struct SurfacePoint {
  int body = -1;            // index of its body; -1 = space
  Int3 vertex{-1, -1, -1};  // of the body's mesh, -1 = unused
  Vec3d weight;             // of each, sum 1
  Vec3d rest;               // position at rest [m]
  Vec3d offset = {};  // of a rolling point, from the present position of `rest` on the axis of a ball or a
                      // capsule [m]
};

/// Motion of a rigid body over a frame, linear in the forces of the coupling around a previous solution.
struct RigidMotion {
  Vec3d rest_center;       // center of mass at rest [m]
  Pose before, after;      // center of mass and rotation before and after the frame, as last solved
  Vec3d turned;            // rotation vector from `before` to `after` [rad]
  Vec3d shift, turn;       // linear part of `after` that the forces of that solution caused [m] [rad]
  double translation = 0;  // h²/m: displacement of the center by a force [m/N]
  Mat3d rotation = {{{}, {}, {}}};  // h² J⁻¹: rotation by a torque [rad/(N m)]
};

/// Inertia of a support that nothing fixes. Over a frame its points yield to the forces as those of a rigid
/// body do; CoupledBody::free has their motion without these forces.
struct SupportInertia {
  Vec3d center;                     // of mass [m]
  double translation = 0;           // h²/m: displacement of the center by a force [m/N]
  Mat3d rotation = {{{}, {}, {}}};  // h² J⁻¹: rotation by a torque [rad/(N m)]
};

/// A body as the coupling sees it. One without any of the models takes no part.
struct CoupledBody {
  const sfem::Model* model = nullptr;  // has a dense store of Green's functions
  double stiffness_scale = 1;          // divides displacements by forces
  std::vector<Vec3d> free;             // displacement of every vertex without forces of the coupling [m]
  std::optional<RigidMotion> rigid;    // instead of the other members
  bool is_support = false;  // it moves as `free` says and does not yield; the forces act on it later
  const rhombus::Model* chains =
      nullptr;  // instead of `model`: yields as a half space (models/rhombus/spread.hpp)
  std::optional<SupportInertia> inertia = {};  // of a support that nothing fixes
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
  double softness = 0;  // compliance besides that of the bodies; 0 = a small one is chosen [m/N]
  Vec3d force;          // on a [N]
  Vec3d borne = {};     // on a: the part that a support bears already (sim/organs/support.hpp) [N]
  SiteState state = SiteState::kOpen;
  bool rolls =
      false;         // true: it moves over the surfaces, so that friction resists the motion of a frame only
  int node = -1;     // of a lattice, which touches in the sweeps of its solver (find_node_sites); -1 = none
  Vec3d ahead = {};  // of such a site: motion of b in the next frame, as predicted [m]
  double permitted = 0;  // of such a site: depth from which it is pushed out slowly (permit_depth) [m]
};

struct CouplingReport {
  int solves = 0;         // of the contact problem
  int broken = 0;         // ties that broke
  bool converged = true;  // false: the forces are those of the last solution
};

/// Displacement of a surface point; zero for a position in space [m].
Vec3d displacement_of(const SurfacePoint& point, std::span<const Vec3d> displacement);
/// Displacement of a point at the end of the frame without forces of the coupling, relative to its position
/// at rest [m].
Vec3d free_displacement(std::span<const CoupledBody> bodies, const SurfacePoint& point);
/// Change of a tie's x(a) − x(b) from its value at rest, without forces of the coupling [m].
Vec3d free_stretch(std::span<const CoupledBody> bodies, const Tie& tie);

struct CouplingStorage;  // coupled_system.hpp

/// Solves for the forces of all ties and sites. Ties whose force exceeds their strength break, the most
/// overloaded one first. The same bits on any number of threads.
CouplingReport solve_coupling(const Exec& exec, std::span<const CoupledBody> bodies, std::span<Tie> ties,
                              std::span<PairSite> sites, CouplingStorage& storage);
/// The same with storage of its own.
CouplingReport solve_coupling(const Exec& exec, std::span<const CoupledBody> bodies, std::span<Tie> ties,
                              std::span<PairSite> sites);

/// Breaks the most overloaded tie; false if none is.
bool break_one(std::span<Tie> ties);
/// Breaks every tie whose force exceeds its strength: of ties whose forces are known once a frame.
void break_overloaded(std::span<Tie> ties);

/// Force and torque about the present center of mass.
struct RigidLoad {
  Vec3d force, torque;  // [N] [N m]
};
/// Load of ties and sites on one rigid body.
RigidLoad load_on(int body, const RigidMotion& motion, std::span<const Tie> ties,
                  std::span<const PairSite> sites);
/// Linearizes the motion around the pose after the frame under a load.
void linearize(const Pose& after, const RigidLoad& load, RigidMotion& motion);
/// Largest difference between the linear motion of the points of one rigid body under a load, and that by the
/// pose after the frame under this load [m].
double linearization_error(int body, const RigidMotion& motion, const Pose& after, const RigidLoad& load,
                           std::span<const Tie> ties, std::span<const PairSite> sites);

/// Forces of ties and sites on the vertices of one body, ascending.
std::vector<VertexForce> forces_on(int body, std::span<const Tie> ties, std::span<const PairSite> sites);

}  // namespace turgor::contact
