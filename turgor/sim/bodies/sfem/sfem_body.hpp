// A body of the sfem model while tools touch it: the body with its Green's functions, the patch that
// follows the tools, what every haptic tick answered, and its surface as pictures show it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/sfem_touch.hpp"
#include "turgor/core/boxed.hpp"
#include "turgor/geometry/embedding.hpp"
#include "turgor/geometry/mesh_quality.hpp"
#include "turgor/models/sfem/patch.hpp"
#include "turgor/models/sfem/rotation.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/bodies/sfem/inner_parts.hpp"
#include "turgor/sim/bodies/sfem/patch_worker.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/live/tick_inputs.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/tools/press_path.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct World;

/// A patch that was built while the tool moved.
struct PatchRebuild {
  double time = 0;              // when it was taken into use [s]
  double seconds = 0;           // wall time of building it, beside the ticks
  double handover_seconds = 0;  // and of taking it into use
  int elements = 0, local_nodes = 0, points = 0;
  double force_jump = 0;  // before it is blended away [N]
};

/// A finer surface that moves with the body.
struct SeenSurface {
  Embedding embedding;
  std::vector<Int3> triangles;
};

/// How the body was made, for the report.
struct SfemFacts {
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

/// Cloth that lies on the body.
struct ClothPress {
  ClothLoad load;
  std::vector<Vec3d> displacement;  // that it makes, of every vertex [m]
};

/// How turned elements and cloth move every vertex; ticks go from where that was a frame ago to where it is
/// now. Empty = nothing does.
struct FreeDisplacement {
  std::vector<Vec3d> before, now;  // [m]
  long told = 0;                   // to a haptic thread, so many times
};

/// Between a haptic thread and the frames, with what awaits its tick in a replay (sim/live/exchanges.hpp).
struct SfemHaptics {
  contact::SfemExchange exchange;
  Awaiting<contact::FreeMotion> motions;
  Awaiting<contact::PatchOffer> patches;
};

struct SfemBody : TouchedBody {
  SfemFacts facts;
  sfem::Model model;
  std::optional<SeenSurface> seen;
  std::vector<InnerPart> inside;

  std::optional<Turning> turning;
  std::optional<ClothPress> press;
  FreeDisplacement free;

  // Of the frame, which wants patches and draws:
  double stiffer = 1;            // than it was made
  std::vector<double> friction;  // of its tools; empty: as they were made
  int refinement = 2;
  int contacts = 32;             // contact::TouchParams::capacity
  std::size_t patch_memory = 0;  // that a patch may take [bytes]
  contact::FollowParams follow;
  std::vector<Vec3d> centers;  // where the present patch was built for [m]
  boxed<PatchWorker> worker;
  std::vector<std::shared_ptr<const sfem::Patch>> patches;  // that somebody may still use
  contact::TouchedNow now;                                  // what ticks left, one for each of tool_indices

  contact::SfemTouch touch;            // who ticks owns this, and nothing else of the body that changes
  boxed<SfemHaptics> haptic;           // while a haptic thread ticks
  int built_patches = 0;               // meanwhile, whatever became of them
  std::optional<bool> patch_is_ready;  // in a replay: at the next frame; else the worker is asked

  std::vector<PatchRebuild> rebuilds;
  int kept_patches = 0;      // times that a patch could not follow: the present one stayed
  std::string kept_because;  // the first time
};

/// Builds the patch where the tools are at the start, and everything a tick needs. Error: the patch takes
/// more than SfemBody::patch_memory, or its numbers do not hold.
Status begin_touch(const Exec& exec, SfemBody& body, const std::vector<TouchingTool>& tools,
                   const contact::Viscosity& viscosity);
/// Ticks from one time to another [s], in order; a tick ends at every whole multiple of kTick. Begins with
/// take_frame and ends with take_touched, as who ticks and who makes frames are one here.
void touch_body(const Exec& exec, SfemBody& body, std::vector<TouchingTool>& tools, double from, double to);

/// For a haptic thread, and for who does again what it did: see sim/live/exchanges.hpp.
void begin_haptics(SfemBody& body, const std::vector<TouchingTool>& tools);
void tick_haptics(SfemBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings);
TickInputs tick_inputs(const SfemBody& body, std::size_t t);
FrameInputs frame_inputs(const SfemBody& body, std::size_t t);
void end_haptics(SfemBody& body);
void keep_frame(SfemBody& body);
void give_frame(SfemBody& body, std::size_t t, TickInputs inputs_used);
/// From the next frame on, Coulomb's coefficient of tool `t` of its tool_indices.
void set_friction(SfemBody& body, std::size_t t, double friction);

/// Of the next frame: is the patch ready that is being built?
void expect_patch(SfemBody& body, bool is_ready);

/// Keeps the last tick of tool `t` of its tool_indices.
void log_tick(const SfemBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool);

/// The frame takes what ticks left: body.now was just filled.
void take_touched(SfemBody& body);

/// A frame of a body that a haptic thread ticks, `frame_dt` long: takes what the ticks left, turns the body,
/// tells where it goes and has its patch follow. Never waits for the haptic thread. contact::prepare came
/// before either; the body stays where it is in memory.
void make_frame(const Exec& exec, SfemBody& body, double time, double frame_dt,
                contact::SfemExchange& exchange);

/// Corrects large rotations for the next frame, if the body does so. The ticks have arrived where free
/// motion led them.
void turn_body(const Exec& exec, SfemBody& body);
/// Feels what cloth does to it, from the next frame on.
void press_body(const Exec& exec, SfemBody& body, const ClothPush& push, double dt);
/// Where the ticks of the next frame go to.
void sum_free_motion(SfemBody& body);
/// Forces on vertices under which the elastic body lies as the body does now: those of the contacts, and
/// what viscous tissue remembers; ascending.
std::vector<contact::VertexForce> coarse_forces_now(const SfemBody& body);

/// Displacement of every vertex of the mesh by the coarse functions; zero where none are kept [m]: of the
/// body as it lies now, and of these forces alone.
std::vector<Vec3d> coarse_displacements(const Exec& exec, const SfemBody& body);
std::vector<Vec3d> displacements(const Exec& exec, const SfemBody& body,
                                 std::span<const contact::VertexForce> forces);

}  // namespace turgor
