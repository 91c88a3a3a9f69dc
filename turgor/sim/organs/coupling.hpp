// Attachments of bodies and contact between bodies in a running world. They are solved once a frame, after
// all bodies have stepped: the forces act during the next frame, whose ticks approach the motion that they
// cause. Bodies are numbered: those of finite elements first, then the rigid ones, then supports, then tools.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/coupled_system.hpp"
#include "turgor/contact/pair_sites.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/sim/scene/organs_scene.hpp"

namespace turgor {

struct Scene;
struct World;

/// Force of an attachment or of a contact in a frame.
struct CouplingSample {
  double time = 0;  // [s]
  Vec3d force;      // on the first body [N]
  double most = 0;  // of a single spring or site [N]
  int bearing = 0;  // springs or sites that bear force
  int sliding = 0;  // sites that slide
};

struct Attachment {
  std::string name;
  std::array<std::string, 2> between;
  std::vector<contact::Tie> ties;
  double area = 0;                      // of the tied surface [m²]
  double stiffness = 0;                 // of all springs together [N/m]
  std::vector<CouplingSample> samples;  // by frame
  double torn_at = 0;                   // time at which the first spring broke [s]
  int swept = -1;                       // see swept_side
  std::vector<Vec3d> ahead;  // swept: displacement of the other point of each tie in the next frame,
                             // as predicted [m]
};

struct BodyContact {
  std::string name;
  std::array<std::string, 2> between;
  std::array<int, 2> body{};  // see coupled_index; -1 = the ground
  contact::GroundPlane ground;
  contact::PairParams params;
  int swept = -1;  // see swept_side
  std::array<std::vector<double>, 2>
      rest_height;                       // see contact::PairSurface; of a swept side, of its nodes [m]
  std::vector<contact::PairSite> sites;  // of the latest frame
  std::vector<CouplingSample> samples;   // by frame
  int dropped_most = 0;                  // touching vertices beyond the capacity, most in a frame
  double deepest = 0;                    // depth of a vertex before it was pushed out, largest [m]
  Vec3d unbalanced;  // swept: what the forces of the last step exceed those on the swept body that its
                     // momentum shows [N]
};

/// Surface nodes of a lattice with the nearest points of its skin; vertices of its surface in a body with
/// partial cells.
struct SweptNodes {
  std::vector<int> slot;                     // of nodes ascending
  std::vector<Vec3d> rest;                   // of the point of the skin, patient frame [m]
  std::vector<int> vertex;                   // of the surface, nearest to the point
  std::vector<lattice::EmbeddedPoint> cell;  // of each vertex, in a body with partial cells; else empty
};

/// A lattice, a body of chains or a cloth in attachments and contacts. The surface of a lattice is where the
/// last step left it, and does not yield while the forces of a frame are solved. They act on it from the next
/// frame on, relaxed like those of cloth (sim/bodies/cloth/cloth_load.hpp). Chains yield in the solution, and
/// bear the whole force in the next frame.
struct CoupledSupport {
  BodyId body;
  std::vector<Vec3d> rest;                   // vertices of its surface without cuts, patient frame [m]
  std::vector<int> carrier;                  // of each: a lattice's slot, or the vertex of the body's model
  std::vector<lattice::EmbeddedPoint> cell;  // of each, in a lattice with partial cells; else empty
  std::vector<Int3> triangles;               // of the surface
  std::vector<contact::VertexForce> force;   // on the body in the next frame, by carrier [N]
  std::vector<contact::VertexForce> solved;  // of chains: the same for forces to which they yielded [N]
  double stiffness = 0;                      // with which the other bodies resist its motion [N/m]
  SweptNodes nodes;                          // of a lattice (organs/swept.hpp)
  double free_mass = 0;                      // of a lattice that nothing fixes, else 0 [kg]
};

struct Coupling {
  std::vector<CoupledSupport> supports;
  std::vector<Attachment> attachments;
  std::vector<BodyContact> contacts;
  int frames = 0, unsolved = 0;      // frames whose forces did not converge
  contact::CouplingStorage storage;  // of the solution of a frame
};

inline bool is_empty(const Coupling& coupling) {
  return coupling.attachments.empty() && coupling.contacts.empty();
}

/// Finds the tied points and the distances at rest. Error: no point within reach, or a body that cannot take
/// part; the message has the source location.
Status load_coupling(const Exec& exec, const Scene& scene, World& world);

/// Present displacement of the vertices of a support [m].
std::vector<Vec3d> support_displacement(const World& world, const CoupledSupport& support);

/// Number of a body in attachments and contacts.
int coupled_index(const World& world, BodyId id);
BodyId coupled_body(const World& world, int index);

/// Solves for the forces of the next frame, and moves bodies without fixed vertices and rigid bodies.
void couple_bodies(const Exec& exec, World& world);
/// The same for the first frame of a world with rigid bodies.
void begin_coupling(const Exec& exec, World& world);

/// Sum of the forces of an attachment on its first body, and of a contact on this body [N].
Vec3d total_force(const std::vector<contact::Tie>& ties);
Vec3d total_force(const std::vector<contact::PairSite>& sites, int body);

std::uint64_t state_hash(const Coupling& coupling, std::uint64_t seed);

}  // namespace turgor
