// A body of the lattice model in a scene: its CT, what is left of that, what holds it, and the tools that
// touch it. Forces come once a frame, at the end of the body's step.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/live/exchanges.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

struct World;

struct LatticeBody : FrameTouchedBody {
  CtVolume ct;
  std::uint64_t ct_hash = 0;  // of the CT's samples and grid
  DicomOrigin ct_origin;      // of a DICOM series
  lattice::Model model;
  lattice::DeviceState state;  // here or on a GPU
  Box box;                     // around its nodes in the CT, along the patient's axes [m]
  double read_seconds = 0, build_seconds = 0;
  std::vector<std::string> notes;  // what was left out while reading
  bool has_gravity = true;
  double last_way = 0;                               // that any node went in the last frame, at most [m]
  std::int64_t row_steps = 0, row_steps_asleep = 0;  // rows that could move in all steps so far; that slept
  ClothLoad cloth;                                   // by slot, along the patient's axes

  // When tools touch it or cloth lies on it:
  lattice::BodySurface surface;  // with the cuts that it has now
  std::vector<Vec3d> rest;       // its vertices, patient frame [m]
  std::size_t surface_cuts = 0;  // cut_version of the state that it was made of
  contact::LatticeTouch touch;
  std::vector<contact::Tool> tools;  // one for each of tool_indices, as the two below
  std::vector<contact::ToolPose> poses;
  std::vector<contact::ToolForce> forces;
};

/// Voxels a lattice step: given, or whole ones that come nearest to the step that is.
Int3 block_of(const LatticeScene& scene, const Grid& ct);
/// Without its tools. Error: names the scene's place.
Result<LatticeBody> load_body(const Loading& loading, const LatticeScene& scene, const World& world);
inline const std::vector<std::string>& notes(const LatticeBody& body) { return body.notes; }

/// Makes the surface, or makes it anew where blades have been at work: the walls they left can be touched.
void keep_surface(LatticeBody& body);
inline void make_rest_surface(LatticeBody& body) { keep_surface(body); }
inline RestSurface rest_surface(const LatticeBody& body) { return {body.rest, body.surface.triangles}; }
Status begin_body(const Exec& exec, LatticeBody& body, const LatticeScene& scene, const World& world);

/// One step, in parts when a tool is fast. Every tool gets a sample.
void step_body(const Exec& exec, LatticeBody& body, World& world, const FrameInput& input,
               FrameReport& report);
/// From the next frame on, Coulomb's coefficient of tool `t` of its tool_indices.
inline void set_friction(LatticeBody& body, std::size_t t, double friction) {
  body.tools[t].friction = friction;
}
/// Feels what cloth does to it, from the next frame on.
void press_body(const Exec& exec, LatticeBody& body, const ClothPush& push, double dt);
std::uint64_t state_hash(const LatticeBody& body, std::uint64_t seed);

/// Tool `t` of its tool_indices.
inline ToolNow tool_now(const LatticeBody& body, std::size_t t, const World&) {
  return {body.poses[t].pose, body.forces[t].force, 0};
}
inline Look look_of(const LatticeBody&) { return Look::kSkin; }
/// Its skin and the walls of its wounds.
void show(const Exec& exec, const LatticeBody& body, BodySnapshot& out);

}  // namespace turgor
