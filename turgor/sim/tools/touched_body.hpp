// Tools of the scene on their way, what they feel, and what bodies of every model that tools touch have in
// common: which tools those are, and the surface as pictures show it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/forceps.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/tools/tool_path.hpp"

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
  float tick_seconds = 0;     // wall time of the tick, of all tools of its body together
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
  BodyId body;  // that it touches
  contact::Tool tool;
  std::optional<contact::Forceps> forceps;
  double closing_time = 0;  // of its jaws [s]
  TriMesh shown;            // about the tool's origin, to be drawn; jaws closed
  ToolPath path;
  std::vector<ForceSample> samples;
  ForceLimits limits;
  std::vector<std::string> notes;  // what a person should know of its path
};

/// A tool as pictures show it.
struct ShownTool {
  contact::Pose pose;
  Vec3d force;         // on the tool [N]
  double opening = 0;  // of its jaws [m]
};

/// The surface at one moment: the coarse one with the patch in it, or the finer one that the scene names.
struct ShownSurface {
  double time = 0;                 // [s]
  std::vector<Vec3> rest;          // [m]
  std::vector<Vec3> displacement;  // [m]
  std::vector<float> pressure;     // of the contact [Pa]
  std::vector<Int3> triangles;     // counter-clockwise seen from outside
  std::vector<ShownTool> tools;    // those that touch this body
  std::vector<int> mesh_vertex;    // which of the body's mesh each vertex is, -1 = none; empty = its number
};

/// What bodies of all models that tools touch have in common.
struct TouchedBody {
  std::string name;
  std::vector<int> tool_indices;        // into World::tools
  std::vector<double> surface_seconds;  // wall times of shown_surface
  ShownSurface shown;                   // at the latest snapshot
  ShownSurface deepest;                 // when the force was largest
  double largest_force = 0;             // then, all tools together [N]
};

}  // namespace turgor
