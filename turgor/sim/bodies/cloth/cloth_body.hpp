// A cloth of the scene while it is simulated: the model, what holds it, what it lies on, and what is
// measured.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/tool.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/device/device_state.hpp"
#include "turgor/models/cloth/measure.hpp"
#include "turgor/sim/bodies/cloth/cloth_support.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/live/exchanges.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/scene/cloth_scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

struct World;

/// Vertices of the mesh that are held now and then.
struct ClothHold {
  HoldScene scene;
  std::vector<int> vertices;  // of the mesh
  std::vector<Vec3> places;   // where they were when they were seized [m]
  bool is_held = false;
  std::string missed;        // where the cloth was when nothing of it was in the ball: a sentence
  std::vector<Vec3d> force;  // that it takes, by frame [N]
};

/// What the cloth stays out of.
struct ClothObstacle {
  std::string name;
  double friction = 0, gap = 0;     // [1] [m]
  std::optional<PlaneScene> plane;  // one of these four
  std::optional<contact::Shape> shape;
  contact::Pose pose;  // of `shape`
  std::shared_ptr<const cloth::MovingSurface> surface;
  std::optional<ClothSupport> support;
  TriMesh snapshot;          // to be drawn; of bodies, nothing
  std::vector<Vec3d> force;  // of the cloth on it, by frame [N]
};

/// One frame.
struct ClothSample {
  double time = 0;           // [s]
  double seconds = 0;        // wall time of the step
  double largest_speed = 0;  // [m/s]
  double residual = -1;      // of the linear system; -1 = was not measured [1]
  int iterations = 0;        // of conjugate gradients
  bool is_snapshot = false;  // what follows was measured
  double energy = 0;         // elastic and kinetic [J]
  double stretch = 0;        // longest spring [1]
  int contacts = 0;
};

struct ClothBody : FrameTouchedBody {
  std::vector<Int3> triangles;  // of the mesh, as the scene gives it
  cloth::Model model;
  cloth::DeviceState state;
  cloth::Air air;
  std::vector<WindTurn> turns;
  std::vector<ClothHold> holds;
  std::vector<ClothObstacle> obstacles;
  std::vector<ClothSample> samples;
  std::vector<std::string> notes;
  double build_seconds = 0;

  // When tools touch it:
  std::vector<Vec3d> rest;           // vertices of the mesh at rest [m]
  std::vector<contact::Tool> tools;  // one for each of tool_indices, as the two below
  std::vector<contact::Pose> poses;
  std::vector<contact::ToolForce> forces;
};

/// Error: a file that cannot be read, a mesh that is no cloth, a held vertex that is not there.
Result<ClothBody> load_body(const Loading& loading, const ClothScene& scene, const World& world);
inline const std::vector<std::string>& notes(const ClothBody& body) { return body.notes; }

void make_rest_surface(ClothBody& body);
inline RestSurface rest_surface(const ClothBody& body) { return {body.rest, body.triangles}; }
Status begin_body(const Exec& exec, ClothBody& body, const ClothScene& scene, const World& world);
/// From the next frame on, Coulomb's coefficient of tool `t` of its tool_indices.
inline void set_friction(ClothBody& body, std::size_t t, double friction) {
  body.tools[t].friction = friction;
}
/// No cloth lies on it by its name.
inline void press_body(const Exec&, ClothBody&, const ClothPush&, double) {}
/// Tool `t` of its tool_indices.
inline ToolNow tool_now(const ClothBody& body, std::size_t t, const World&) {
  return {body.poses[t], body.forces[t].force, 0};
}

/// One frame, after the bodies it lies on. Every tool gets a sample.
void step_body(const Exec& exec, ClothBody& body, World& world, const FrameInput& input, FrameReport& report);
std::uint64_t state_hash(const ClothBody& body, std::uint64_t seed);

inline Look look_of(const ClothBody&) { return Look::kCloth; }
/// In the model's numbering.
void show(const Exec& exec, const ClothBody& body, BodySnapshot& out);

}  // namespace turgor
