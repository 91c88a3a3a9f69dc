// An organ of the sfem model while tools touch it: the body with its Green's functions, the patch that
// follows the tools, what every haptic tick answered, and its surface as pictures show it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/follow.hpp"
#include "turgor/contact/forceps.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/geometry/embedding.hpp"
#include "turgor/geometry/mesh_quality.hpp"
#include "turgor/models/sfem/patch.hpp"
#include "turgor/models/sfem/rotation.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/cloth_load.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/tool_path.hpp"

namespace turgor {

constexpr double kTick = 1e-3;  // of the haptic loop [s]

/// What a tool felt in one tick.
struct ForceSample {
  double time = 0;            // [s]
  Vec3d position;             // of the tool's origin [m]
  Vec3d force, torque;        // on the tool, the torque about its origin [N] [N·m]
  int contacts = 0;           // places that bear force
  double depth = 0;           // of the tool's deepest point below the surface at rest [m]
  double path = 0;            // that the tool has gone until now [m]
  float tick_seconds = 0;     // wall time of the tick, of all tools of its organ together
  bool new_patch = false;     // the patch was rebuilt before this tick
  bool beyond_patch = false;  // the tool reaches beyond the patch
};

/// Where a model could not, or would not, bear what a tool asked of it.
struct ForceLimits {
  int coarsest = 0;      // level of contact sites (contact::Site::level); 0 = every point by itself
  int dropped_most = 0;  // touched places that had no room in a tick
  int dropped_ticks = 0;
  int slips = 0;           // out of what it held
  double slipped_at = 0;   // first [s]
  int yielding_ticks = 0;  // pressed harder than the tissue bears
};

/// A tool of the scene on its way.
struct TouchingTool {
  std::string name;
  int organ = 0;  // touched_organ(world, organ)
  contact::Tool tool;
  std::optional<contact::Forceps> forceps;
  double closing_time = 0;  // of its jaws [s]
  TriMesh shown;            // about the tool's origin, to be drawn; jaws closed
  ToolPath path;
  std::vector<ForceSample> samples;
  ForceLimits limits;
  std::vector<std::string> notes;  // what a person should know of its path
};

/// A patch that was built while the tool moved.
struct PatchRebuild {
  double time = 0;              // when it was taken into use [s]
  double seconds = 0;           // wall time of building it, beside the ticks
  double handover_seconds = 0;  // and of taking it into use
  int elements = 0, local_nodes = 0, points = 0;
  double force_jump = 0;  // before it is blended away [N]
};

/// A tool as pictures show it.
struct ShownTool {
  contact::Pose pose;
  Vec3d force;         // on the tool [N]
  double opening = 0;  // of its jaws [m]
};

/// The surface at one moment: the coarse one with the patch in it, or the finer one that the scene names.
struct OrganSurface {
  double time = 0;                 // [s]
  std::vector<Vec3> rest;          // [m]
  std::vector<Vec3> displacement;  // [m]
  std::vector<float> pressure;     // of the contact [Pa]
  std::vector<Int3> triangles;     // counter-clockwise seen from outside
  std::vector<ShownTool> tools;    // those that touch this organ
};

/// A finer surface that moves with the body.
struct SeenSurface {
  Embedding embedding;
  std::vector<Int3> triangles;
};

/// How the organ was made, for the report.
struct OrganFacts {
  MeshQuality quality;       // of tetrahedra
  double volume = 0;         // of the mesh [m³]
  double input_volume = 0;   // of the label or the surface it was made from; 0 = there was none [m³]
  double shape_seconds = 0;  // reading and meshing
  double green_seconds = 0;  // computing, or reading from the cache
  bool from_cache = false, on_demand = false;
  sfem::GreenCost cost;
  std::string cache_file;  // empty = none
  std::uint64_t content_hash = 0;
  std::vector<std::string> notes;
};

/// Large rotations, corrected once a frame.
struct Turning {
  sfem::Corotation corotation;
  sfem::RotationState state;
  int frames = 0, unconverged = 0;
  double largest_residual = 0;  // see sfem::RotationReport
};

/// Cloth that lies on the organ.
struct ClothPress {
  ClothLoad load;
  std::vector<Vec3d> displacement;  // that it makes, of every vertex [m]
};

/// How turned elements and cloth move every vertex; ticks go from where that was a frame ago to where it is
/// now. Empty = nothing does.
struct FreeMotion {
  std::vector<Vec3d> before, now;  // [m]
};

/// What organs of all models have in common.
struct TouchedOrgan {
  std::string name;
  std::vector<int> tool_indices;        // into World::tools
  std::vector<double> surface_seconds;  // wall times of shown_surface
  OrganSurface shown;                   // at the latest snapshot
  OrganSurface deepest;                 // when the force was largest
  double largest_force = 0;             // then, all tools together [N]
};

struct Organ : TouchedOrgan {
  OrganFacts facts;
  sfem::Model model;
  std::optional<SeenSurface> seen;

  std::optional<Turning> turning;
  std::optional<ClothPress> press;
  FreeMotion free;

  int refinement = 2;
  int contacts = 32;             // contact::TouchParams::capacity
  std::size_t patch_memory = 0;  // that a patch may take [bytes]
  contact::FollowParams follow;
  sfem::Patch patch;
  contact::TouchState touch;
  std::vector<Vec3d> centres;  // where the present patch was built for [m]

  std::vector<contact::Tool> tools;  // one for each of tool_indices, as the two below
  std::vector<contact::ToolPose> poses;
  std::vector<contact::ToolForce> forces;

  std::vector<PatchRebuild> rebuilds;
  int kept_patches = 0;      // times that a patch could not follow: the present one stayed
  std::string kept_because;  // the first time
};

/// The surface as it lies now.
OrganSurface shown_surface(const Exec& exec, const Organ& organ, double time);

/// Builds the patch where the tools are at the start, and everything a tick needs. Error: the patch takes
/// more than Organ::patch_memory, or its numbers do not hold.
Status begin_touch(const Exec& exec, Organ& organ, const std::vector<TouchingTool>& tools,
                   const contact::Viscosity& viscosity);
/// Ticks from one time to another [s], in order; a tick ends at every whole multiple of kTick.
void touch_organ(const Exec& exec, Organ& organ, std::vector<TouchingTool>& tools, double from, double to);

/// Corrects large rotations for the next frame, if the organ does so. The ticks have arrived where free
/// motion led them.
void turn_organ(const Exec& exec, Organ& organ);
/// Feels what cloth does to it, from the next frame on.
void press_organ(const Exec& exec, Organ& organ, const ClothPush& push, double dt);
/// Where the ticks of the next frame go to.
void sum_free_motion(Organ& organ);
/// Forces on vertices under which the elastic body lies as the organ does now: those of the contacts, and
/// what viscous tissue remembers; ascending.
std::vector<contact::VertexForce> coarse_forces_now(const Organ& organ);

/// Keeps the surface when the force on the tools is the largest so far.
void remember_deepest(const Exec& exec, Organ& organ, double time);

/// Displacement of every vertex of the mesh by the coarse functions; zero where none are kept [m]: of the
/// organ as it lies now, and of these forces alone.
std::vector<Vec3d> coarse_displacements(const Exec& exec, const Organ& organ);
std::vector<Vec3d> displacements(const Exec& exec, const Organ& organ,
                                 std::span<const contact::VertexForce> forces);

/// How far the deepest point of a tool is below the surface of the patch at rest; 0 = it does not touch [m].
double depth_at_rest(const Organ& organ, const contact::Tool& tool, const contact::Pose& pose);

}  // namespace turgor
