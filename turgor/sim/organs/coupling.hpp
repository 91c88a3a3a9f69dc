// Attachments of bodies and contact between bodies in a running world. They are solved once a frame, after
// all bodies have stepped: the forces act during the next frame, whose ticks approach the motion that they
// cause.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/pair_sites.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
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
};

struct BodyContact {
  std::string name;
  std::array<std::string, 2> between;
  std::array<int, 2> body{};  // into World::sfem_bodies
  contact::PairParams params;
  std::array<std::vector<double>, 2> rest_height;  // see contact::PairSurface [m]
  std::vector<contact::PairSite> sites;            // of the latest frame
  std::vector<CouplingSample> samples;             // by frame
  int dropped_most = 0;                            // touching vertices beyond the capacity, most in a frame
  double deepest = 0;                              // depth of a vertex before it was pushed out, largest [m]
};

struct Coupling {
  std::vector<Attachment> attachments;
  std::vector<BodyContact> contacts;
  int frames = 0, unsolved = 0;  // frames whose forces did not converge
};

inline bool is_empty(const Coupling& coupling) {
  return coupling.attachments.empty() && coupling.contacts.empty();
}

/// Finds the tied points and the distances at rest. Error: no point within reach, or a body that cannot take
/// part; the message has the source location.
Status load_coupling(const Exec& exec, const Scene& scene, World& world);

/// Solves for the forces of the next frame, and moves bodies without fixed vertices.
void couple_bodies(const Exec& exec, World& world);

/// Sum of the forces of an attachment on its first body, and of a contact on this body [N].
Vec3d total_force(const std::vector<contact::Tie>& ties);
Vec3d total_force(const std::vector<contact::PairSite>& sites, int body);

std::uint64_t state_hash(const Coupling& coupling, std::uint64_t seed);

}  // namespace turgor
