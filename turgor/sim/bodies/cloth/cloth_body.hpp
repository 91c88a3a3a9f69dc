// Cloth body of a running world: model, holds, obstacles and measurements.
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

/// Vertices held during an interval.
struct ClothHold {
  HoldScene scene;
  std::vector<int> vertices;    // indices in the mesh
  std::vector<Vec3> positions;  // when they were grasped [m]
  bool is_held = false;
  std::string missed;        // location of the cloth if its ball contained no vertex: a sentence
  std::vector<Vec3d> force;  // on the hold, by frame [N]
};

/// Obstacle of a cloth.
struct ClothObstacle {
  std::string name;
  double friction = 0, gap = 0;     // [1] [m]
  std::optional<PlaneScene> plane;  // exactly one of plane, shape, surface and support
  std::optional<contact::Shape> shape;
  contact::Pose pose;  // of `shape`
  std::shared_ptr<const cloth::MovingSurface> surface;
  std::optional<ClothSupport> support;
  TriMesh mesh;              // for drawing; empty for bodies
  std::vector<Vec3d> force;  // of the cloth on the obstacle, by frame [N]
};

/// Measurements of one frame.
struct ClothSample {
  double time = 0;           // [s]
  double seconds = 0;        // wall time of the step
  double largest_speed = 0;  // [m/s]
  double residual = -1;      // of the linear system; -1 = not measured [1]
  int iterations = 0;        // of conjugate gradients
  bool is_snapshot = false;  // true if energy and stretch were measured
  double energy = 0;         // elastic and kinetic [J]
  double stretch = 0;        // of the longest spring [1]
  int contacts = 0;
};

struct ClothBody : FrameTouchedBody {
  std::vector<Int3> triangles;  // of the mesh as given by the scene
  cloth::Model model;
  cloth::Fabric fabric;        // of the scene, which the model has with its stiffness scaled
  double stiffness_scale = 1;  // of the model, relative to `fabric`
  cloth::DeviceState state;
  cloth::Air air;
  std::vector<WindTurn> turns;
  std::vector<ClothHold> holds;
  std::vector<ClothObstacle> obstacles;
  std::vector<ClothSample> samples;
  std::vector<std::string> notes;
  double build_seconds = 0;

  // used if tools touch the cloth
  std::vector<Vec3d> rest;           // vertices of the mesh at rest [m]
  std::vector<contact::Tool> tools;  // one for each of tool_indices, as the two arrays below
  std::vector<contact::Pose> poses;
  std::vector<contact::ToolForce> forces;
};

/// Error: unreadable file, invalid mesh, or a held vertex that does not exist.
Result<ClothBody> load_body(const Loading& loading, const ClothScene& scene, const World& world);
inline const std::vector<std::string>& notes(const ClothBody& body) { return body.notes; }

void make_rest_surface(const Exec& exec, ClothBody& body);
inline RestSurface rest_surface(const ClothBody& body) { return {body.rest, body.triangles}; }
Status begin_body(const Exec& exec, ClothBody& body, const ClothScene& scene, const World& world);
/// Sets Coulomb's coefficient of tool `t` of tool_indices, from the next frame on.
inline void set_friction(ClothBody& body, std::size_t t, double friction) {
  body.tools[t].friction = friction;
}
/// Cloth cannot be a named obstacle of another cloth.
inline void press_body(const Exec&, ClothBody&, const ClothForces&, double) {}
/// State of tool `t` of tool_indices.
inline ToolNow tool_now(const ClothBody& body, std::size_t t, const World&) {
  return {body.poses[t], body.forces[t].force, 0};
}

/// Steps one frame, after the bodies below the cloth. Every tool gets a sample.
void step_body(const Exec& exec, ClothBody& body, World& world, const FrameInput& input, FrameReport& report);
std::uint64_t state_hash(const ClothBody& body, std::uint64_t seed);

inline Look look_of(const ClothBody&) { return Look::kCloth; }
/// In the model's vertex order.
void show(const Exec& exec, const ClothBody& body, BodySnapshot& out);

}  // namespace turgor
