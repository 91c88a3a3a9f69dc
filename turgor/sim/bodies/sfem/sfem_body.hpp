// Body of the sfem model: mesh with Green's functions, the patch that follows the tools, results of haptic
// ticks, and the drawn surface.
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
#include "turgor/sim/bodies/sfem/inner_regions.hpp"
#include "turgor/sim/bodies/sfem/law_solver.hpp"
#include "turgor/sim/bodies/sfem/patch_worker.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/live/tick_inputs.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/tools/press_path.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct World;

/// A patch built during the simulation.
struct PatchRebuild {
  double time = 0;              // of its first use [s]
  double seconds = 0;           // wall time of building it concurrently
  double handover_seconds = 0;  // wall time of the exchange
  int elements = 0, local_nodes = 0, points = 0;
  double force_jump = 0;     // before blending [N]
  bool is_solution = false;  // of a nonlinear law on the same points; else a patch elsewhere
};

/// A finer surface embedded in the body.
struct SeenSurface {
  Embedding embedding;
  std::vector<Int3> triangles;
};

/// Facts about loading, for the report.
struct SfemFacts {
  MeshQuality quality;       // of tetrahedra
  double volume = 0;         // of the mesh [m³]
  double input_volume = 0;   // of the source label or surface; 0 = none [m³]
  double shape_seconds = 0;  // reading and meshing
  double green_seconds = 0;  // computing, or reading from the cache
  bool from_cache = false, on_demand = false;
  sfem::GreenCost cost;
  std::string cache_file;  // empty = no cache
  std::uint64_t content_hash = 0;
  std::vector<std::string> notes;
};

/// Correction of large rotations, once per frame.
struct Turning {
  sfem::Corotation corotation;
  sfem::RotationState state;
  int frames = 0, unconverged = 0;
  double largest_residual = 0;  // see sfem::RotationReport
};

/// Cloth on the body.
struct ClothPress {
  ClothLoad load;
  std::vector<Vec3d> displacement;  // due to cloth, of every vertex [m]
};

/// Attachments and other bodies that act on the body, during one frame (sim/organs/coupling.hpp).
struct CouplingLoad {
  std::vector<contact::VertexForce> force;  // ascending [N]
  std::vector<Vec3d> displacement;          // due to them, of every vertex [m]
};

/// Motion of a body without fixed vertices, by implicit Euler: (K + M/h²) u = f + M (u₀ + h v₀)/h² + M g.
struct FreeFlight {
  std::vector<Vec3d> u, v;          // of every vertex at the end of the latest frame [m], [m/s]
  std::vector<Vec3d> displacement;  // in the next frame due to inertia and weight alone [m]
};

/// Displacement of all vertices due to rotated elements and cloth. Ticks interpolate from the previous
/// frame's value to the present one. Empty = none.
struct FreeDisplacement {
  std::vector<Vec3d> before, now;  // [m]
  long number = 0;                 // number of published motions
};

/// Displacements by needles, of all vertices and around each needle. One list for each of tool_indices; empty
/// for others.
struct NeedleDisplacement {
  std::shared_ptr<const sfem::InnerGreen> inner;                // newest Green's functions around the needles
  std::vector<std::shared_ptr<const sfem::InnerGreen>> in_use;  // that the haptic thread may have
  std::vector<std::vector<Vec3d>> displacement;                 // of all vertices, by each needle [m]
  std::vector<Vec3d> by_tools;             // of all vertices, by other tools; empty without them [m]
  std::vector<std::vector<Vec3d>> motion;  // of InnerGreen's vertices, by everything else [m]
  std::vector<double> target_motion;       // largest displacement of each of SfemBody::inside so far [m]
};

/// Exchange with a haptic thread, and queues of a replay (sim/live/exchanges.hpp).
struct SfemHaptics {
  contact::SfemExchange exchange;
  ReplayQueue<contact::FreeMotion> motions;
  ReplayQueue<contact::FinishedPatch> patches;
  boxed<LawSolver> solver;  // null: frames solve a nonlinear patch, or the body is linear
  ReplayedForces forces;    // of a replay, as the next
  long replayed = 0;        // PatchSolution::tick of the latest solution
};

struct SfemBody : TouchedBody {
  SfemBody() = default;
  SfemBody(const SfemBody&) = default;
  SfemBody(SfemBody&&) = default;
  SfemBody& operator=(const SfemBody&) = default;
  SfemBody& operator=(SfemBody&&) = default;
  /// Ends the worker first, which may be solving `nonlinear`. Copies settle it first for the same reason.
  ~SfemBody() { worker.reset(); }

  SfemFacts facts;
  sfem::Model model;
  std::optional<SeenSurface> seen;
  std::vector<InnerRegion> inside;
  std::vector<double> toughness;  // of each material against needles; negative: the needle's own [J/m²]

  std::optional<Turning> turning;
  std::optional<ClothPress> press;
  std::optional<CouplingLoad> coupling;
  std::optional<FreeFlight> flight;  // null: fixed vertices hold the body
  FreeDisplacement free;
  NeedleDisplacement needles;

  // owned by the frame thread, which requests patches and draws
  double stiffness_scale = 1;    // relative to the loaded stiffness
  std::vector<double> friction;  // of its tools; empty: unchanged
  int refinement = 2;
  bool radius_is_open = false, refinement_is_open = false;  // true: the scene leaves it to choose_patch
  int contacts = 48;                                        // contact::TouchParams::capacity
  std::size_t patch_memory = 0;                             // limit of a patch [bytes]
  contact::FollowParams follow;
  std::vector<Vec3d> centers;  // contact positions of the present patch [m]
  boxed<PatchWorker> worker;
  std::optional<sfem::Law> law;           // of the patch's elements
  boxed<sfem::NonlinearPatch> nonlinear;  // used by the worker while it is busy
  std::vector<Vec3d> law_forces;          // on the points, of its latest solution [N]
  std::vector<double> law_displacement;   // of NonlinearPatch::u, from a file [m]
  LawSummary law_summary;
  // largest of the surface at the end of a frame, without large rotations: of the patch, and of the whole
  // body if other bodies act on it
  double surface_strain = 0;
  Prony viscosity;                                          // ticks get it with the next frame
  std::vector<std::shared_ptr<const sfem::Patch>> patches;  // patches that may be in use
  contact::SfemTouchSnapshot now;  // latest touch state, one for each of tool_indices

  contact::SfemTouch touch;   // owned by the ticking thread, which changes nothing else of the body
  boxed<SfemHaptics> haptic;  // null without a haptic thread
  int built_patches = 0;      // patches built while a haptic thread ran
  std::optional<bool>
      patch_is_ready;  // replay: whether the patch is ready at the next frame; else the worker decides

  std::vector<PatchRebuild> rebuilds;
  int rejected_patches = 0;      // patches that could not be built: the previous one stayed
  std::string rejection_reason;  // reason of the first one
};

/// Builds the patch at the initial tool positions, and all data for ticks. Error: the patch exceeds
/// SfemBody::patch_memory, or has invalid numbers.
Status begin_touch(const Exec& exec, SfemBody& body, const std::vector<TouchingTool>& tools,
                   const Prony& viscosity);
/// Runs the ticks between two times [s]; a tick ends at every multiple of kTick. Includes take_free_motion
/// and read_touch_snapshot, since ticks and frames share a thread here.
void touch_body(const Exec& exec, SfemBody& body, std::vector<TouchingTool>& tools, double from, double to);

/// Functions for a haptic thread and for replays: see sim/live/exchanges.hpp.
void begin_haptics(SfemBody& body, const std::vector<TouchingTool>& tools);
void tick_haptics(SfemBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings);
TickInputs tick_inputs(const SfemBody& body, std::size_t t);
FrameInputs frame_inputs(const SfemBody& body, std::size_t t);
void end_haptics(SfemBody& body);
/// Solves a nonlinear patch beside the ticks from now on: on a thread of its own, or in a replay before the
/// ticks that used the solutions. Does nothing for a linear body. Error: no thread; then frames solve it.
Status begin_solutions(SfemBody& body, bool is_replay);
/// Adds the solutions since the latest frame to those of the body.
void collect_solutions(SfemBody& body);
void queue_frame_output(SfemBody& body);
void replay_frame_output(SfemBody& body, std::size_t t, TickInputs inputs_used);
/// Sets Coulomb's coefficient of tool `t` of tool_indices, from the next frame on.
void set_friction(SfemBody& body, std::size_t t, double friction);

/// Replay: states whether the patch under construction is ready for the next frame.
void expect_patch(SfemBody& body, bool is_ready);

/// Logs the last tick of tool `t` of tool_indices.
void log_tick(const SfemBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool);

/// Processes the touch state, after body.now was filled.
void read_touch_snapshot(SfemBody& body);

/// One frame of duration `frame_dt` of a body ticked by a haptic thread: reads the touch state, corrects
/// rotations, publishes the motion, and lets the patch follow. It never waits for the haptic thread. Requires
/// contact::prepare; the body must not move in memory.
void make_frame(const Exec& exec, SfemBody& body, double time, double frame_dt,
                contact::SfemExchange& exchange);

/// Corrects large rotations for the next frame, if enabled. The ticks have reached the present free motion.
void correct_rotations(const Exec& exec, SfemBody& body);
/// Applies forces of cloth, from the next frame on.
void press_body(const Exec& exec, SfemBody& body, const ClothForces& push, double dt);
/// Displacement of all vertices under forces, solved with the factor [m].
std::vector<Vec3d> displacement_by_factor(const sfem::Model& model,
                                          std::span<const contact::VertexForce> forces);
/// Displacement of every vertex due to tools, and of the next frame due to all but attachments and other
/// bodies [m].
std::vector<Vec3d> tool_displacement(const Exec& exec, const SfemBody& body);
std::vector<Vec3d> uncoupled_displacement(const SfemBody& body, std::vector<Vec3d> by_tools);
/// Applies forces of attachments and other bodies, from the next frame on.
void couple_body(const Exec& exec, SfemBody& body, std::vector<contact::VertexForce> forces);
/// Ends a frame of a body without fixed vertices, and begins the next one.
void advance_flight(SfemBody& body, const std::vector<Vec3d>& by_tools, Vec3d gravity, double dt);
/// Target of the free motion of the next frame.
void sum_free_motion(SfemBody& body);
/// Vertex forces that give the present elastic shape: contact forces and the memory of viscous tissue;
/// ascending.
std::vector<contact::VertexForce> coarse_forces_now(const SfemBody& body);

/// Displacement of every mesh vertex by the coarse functions; zero where none are kept [m]. The first is of
/// the present body, the second of these forces only.
std::vector<Vec3d> coarse_displacements(const Exec& exec, const SfemBody& body);
std::vector<Vec3d> displacements(const Exec& exec, const SfemBody& body,
                                 std::span<const contact::VertexForce> forces);

}  // namespace turgor
