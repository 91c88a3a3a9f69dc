// A body of the lattice model in a scene: its CT, what is left of that, what holds it, and the tools that
// touch it. Forces come once a frame, at the end of the body's step.
#pragma once

#include <string>
#include <vector>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct LatticeBody : TouchedBody {
  CtVolume ct;
  std::uint64_t ct_hash = 0;  // of the CT's samples and grid
  lattice::Model model;
  lattice::State state;
  double read_seconds = 0, build_seconds = 0;
  std::vector<std::string> notes;  // what was left out while reading
  bool has_gravity = true;
  ClothLoad cloth;  // by slot, along the patient's axes

  // When tools touch it:
  lattice::BodySurface surface;  // with the cuts that it has now
  std::vector<Vec3d> rest;       // its vertices, patient frame [m]
  std::size_t surface_cuts = 0;  // edges that were cut when it was made
  contact::LatticeTouch touch;
  std::vector<contact::Tool> tools;  // one for each of tool_indices, as the two below
  std::vector<contact::ToolPose> poses;
  std::vector<contact::ToolForce> forces;
};

/// Without its tools. Error: names the scene's place.
Result<LatticeBody> load_lattice(const Exec& exec, const LatticeScene& scene, const BeginWork& begin);

/// Makes the surface that tools touch, when the first one comes.
void make_rest_surface(LatticeBody& body);
inline RestSurface rest_surface(const LatticeBody& body) { return {body.rest, body.surface.triangles}; }
void begin_touch(LatticeBody& body, const std::vector<TouchingTool>& tools);
/// One step from one time to another [s], in parts when a tool is fast. Every tool gets a sample.
lattice::StepReport step_lattice(const Exec& exec, LatticeBody& body, std::vector<TouchingTool>& tools,
                                 const lattice::Inputs& inputs, double from, double to);

/// The tools as they are now, without the surface: that is drawn as skin.
ShownSurface shown_tools(const LatticeBody& body, double time);
/// Keeps the surface when the force on the tools is the largest so far.
void remember_deepest(LatticeBody& body, double time);

}  // namespace turgor
