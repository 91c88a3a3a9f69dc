// Body of the lattice model: CT, model, state, and the tools that touch it. Contact forces are computed once
// per frame, at the end of the body's step.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/geometry/signed_distance.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface_cache.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/bodies/lattice/needle_lattice.hpp"
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
  std::string ct_series;      // its description
  lattice::Model model;
  lattice::DeviceState state;  // on the host or on a GPU
  Box box;                     // around its nodes in the CT, patient frame [m]
  double read_seconds = 0, build_seconds = 0;
  std::vector<std::string> notes;  // notes of the CT's reader
  std::vector<Vec3>
      fiber_lines;  // directions of fibers from an image, by slot (fiber_lines.hpp); may be empty
  bool has_gravity = true;
  double stiffness_scale = 1;                        // of the model, relative to the scene's tissue
  double last_displacement = 0;                      // bound for all nodes in the last frame [m]
  std::int64_t row_steps = 0, row_steps_asleep = 0;  // sums over all steps: movable rows, and sleeping rows
  ClothLoad cloth;                                   // by slot, patient frame

  // used if tools or cloth touch the body
  lattice::BodySurface surface;          // with the present cuts
  std::vector<Vec3d> rest;               // of its vertices, patient frame [m]
  std::size_t surface_cuts = 0;          // cut version of `surface`
  lattice::detail::SurfaceCache meshed;  // cells of `surface`
  SignedDistance rest_skin;              // to the surface at rest without cuts, patient frame
  contact::LatticeTouch touch;
  std::vector<contact::Tool> tools;  // one for each of tool_indices, as the two arrays below
  std::vector<contact::ToolPose> poses;
  std::vector<contact::ToolForce> forces;
  NeedleLayers layers;
  std::vector<std::optional<Rgb>> layer_colors;  // of the model's layers, on walls of wounds
  std::vector<contact::LatticeNeedle> needles;   // one for each tool; unused for other tools, empty without
};

/// Voxels per lattice spacing: as given, or rounded from the given spacing.
Int3 block_of(const LatticeScene& scene, const Grid& ct);
/// Body without tools. Error: has the source location.
Result<LatticeBody> load_body(const Loading& loading, const LatticeScene& scene, const World& world);
inline const std::vector<std::string>& notes(const LatticeBody& body) { return body.notes; }

/// Builds the surface, and rebuilds it after cuts, so that wound walls can be touched.
void refresh_surface(const Exec& exec, LatticeBody& body);
inline void make_rest_surface(const Exec& exec, LatticeBody& body) { refresh_surface(exec, body); }
inline RestSurface rest_surface(const LatticeBody& body) { return {body.rest, body.surface.triangles}; }
Status begin_body(const Exec& exec, LatticeBody& body, const LatticeScene& scene, const World& world);

/// Steps one frame, in substeps for fast tools. Every tool gets a sample.
void step_body(const Exec& exec, LatticeBody& body, World& world, const FrameInput& input,
               FrameReport& report);
/// Sets Coulomb's coefficient of tool `t` of tool_indices, from the next frame on.
inline void set_friction(LatticeBody& body, std::size_t t, double friction) {
  body.tools[t].friction = friction;
}
/// Applies forces of cloth, from the next frame on.
void press_body(const Exec& exec, LatticeBody& body, const ClothForces& push, double dt);
std::uint64_t state_hash(const LatticeBody& body, std::uint64_t seed);

/// State of tool `t` of tool_indices.
inline ToolNow tool_now(const LatticeBody& body, std::size_t t, const World&) {
  return {body.poses[t].pose, body.forces[t].force, 0};
}
inline Look look_of(const LatticeBody&) { return Look::kSkin; }
/// Skin and wound walls.
void show(const Exec& exec, const LatticeBody& body, BodySnapshot& out);

}  // namespace turgor
