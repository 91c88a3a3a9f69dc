// Rigid body in a running world. Frames move it to the pose that the coupling of bodies computed at the end
// of the frame before (sim/organs/coupling.hpp).
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "turgor/core/result.hpp"
#include "turgor/models/rigid/rigid.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/bodies/rigid/touch_rigid.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/live/exchanges.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/scene/rigid_scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

struct ReportInput;
struct SnapshotOut;
struct SnapshotIn;

/// Motion of a frame.
struct RigidSample {
  double time = 0;                  // [s]
  Vec3d center;                     // of mass [m]
  Quaternion rotation{1, 0, 0, 0};  // from the rotation at the beginning
  Vec3d velocity, spin;             // of the middle of the frame [m/s] [rad/s]
};

struct RigidBody : FrameTouchedBody {
  rigid::Model model;
  rigid::State state;
  rigid::State next;                 // at the end of the next frame
  double radius = 0;                 // largest distance of a vertex from the center of mass [m]
  TriMesh drawn;                     // at rest; has several vertices at sharp edges
  double touch_stiffness = 2000;     // of a point that a tool touches [N/m]
  std::vector<RigidTouch> touches;   // one for each of tool_indices
  ClothLoad cloth;                   // by vertex
  contact::RigidLoad borne;          // of cloth that moves with the body, in the next frame
  std::vector<RigidSample> samples;  // by frame
  std::vector<std::string> notes;
};

/// Error: a file that is no closed surface; the message has the source location.
Result<RigidBody> load_body(const Loading& loading, const RigidScene& scene, const World& world);
inline const std::vector<std::string>& notes(const RigidBody& body) { return body.notes; }

inline void make_rest_surface(const Exec&, RigidBody&) {}  // exists already
inline RestSurface rest_surface(const RigidBody& body) { return {body.model.vertices, body.model.triangles}; }
Status begin_body(const Exec& exec, RigidBody& body, const RigidScene& scene, const World& world);
/// Sets Coulomb's coefficient of tool `t` of tool_indices, from the next frame on.
inline void set_friction(RigidBody& body, std::size_t t, double friction) {
  body.touches[t].tool.friction = friction;
}
/// Applies forces of cloth, from the next frame on.
void press_body(const Exec& exec, RigidBody& body, const ClothForces& push, double dt);
/// Load of cloth about the center of mass.
contact::RigidLoad cloth_load_on(const RigidBody& body);
/// State of tool `t` of tool_indices.
inline ToolNow tool_now(const RigidBody& body, std::size_t t, const World&) {
  return {body.touches[t].pose, body.touches[t].force.force, 0};
}

/// Moves the body to its next state. Every tool gets a sample.
void step_body(const Exec& exec, RigidBody& body, World& world, const FrameInput& input, FrameReport& report);
std::uint64_t state_hash(const RigidBody& body, std::uint64_t seed);

inline Look look_of(const RigidBody&) { return Look::kCloth; }
void show(const Exec& exec, const RigidBody& body, BodySnapshot& out);

nlohmann::ordered_json report_body(const ReportInput& input, const RigidScene& scene, const RigidBody& body,
                                   BodyId id);
Status write_state(const SnapshotOut& out, const RigidBody& body, BodyId id);
Status read_state(const SnapshotIn& in, RigidBody& body, BodyId id);

}  // namespace turgor
