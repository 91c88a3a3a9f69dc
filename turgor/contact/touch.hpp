// One haptic tick: where tools touch the surface of a patch, which forces keep them apart, and how the patch
// moves. Poses go in, forces come out; nothing is allocated, and time enters through friction's memory and
// viscosity alone.
//
//   find_sites   points (and places inside triangles, for tools smaller than those) that a tool touches or
//   may
//                touch in this tick, as the surface lies after the last one       (sites.hpp)
//   solve        the forces                                                       (coulomb.hpp)
//   u = Ξ f      of all points, and what the material remembers                   (viscosity.hpp)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/contact/viscosity.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

struct Tool {
  Shape shape;
  double friction = 0.3;  // Coulomb's μ [1]
};

struct ToolPose {
  Pose pose;
  bool hold = false;  // what is touched when this begins is carried with the tool until it ends
};

/// On a tool.
struct ToolForce {
  Vec3d force;                     // [N]
  Vec3d torque;                    // about the tool's origin [N·m]
  int contacts = 0;                // sites that bear force
  int sliding = 0;                 // those of them that slide
  double largest_penetration = 0;  // of a point after the tick [m]
  double area = 0;                 // around the sites that bear force, at rest [m²]
  int dropped = 0;                 // touched sites beyond TouchParams::capacity
  bool invalid_pose = false;       // not finite or not a rotation: no contact in this tick
  bool inside = false;             // it appeared inside the body: no contact until it has come out
  bool beyond_patch = false;       // it touches the border of the patch: a larger patch is needed
};

struct TouchParams {
  int capacity = 32;  // sites of all tools together
  Viscosity viscosity;
  CoulombParams solver;
};

/// A place on the surface: one point of the patch, or somewhere in a triangle.
struct Site {
  int tool = 0;
  int triangle = -1;    // -1: a point
  Int3 point;           // of the patch; a point alone is point.x
  Vec3d weight;         // of each, sum 1
  double distance = 0;  // from the tool, before the tick [m]
  Vec3d normal;         // from the tool at the body, unit
  Vec3d anchor;         // where it sticks, or is held, in the tool's frame [m]
  Vec3d force;          // on the body [N]
  SiteState state = SiteState::kOpen;
};

/// What follows from the points and triangles of a patch alone.
struct PatchSurface {
  std::vector<Vec3d> normal;         // of each point at rest, unit, outward
  std::vector<double> area;          // a third of the triangles around it [m²]
  std::vector<double> longest_edge;  // of each triangle [m]
  std::vector<std::uint8_t> border;  // 1: on the edge of the patch
  double largest_edge = 0;           // [m]
};
void measure_surface(const sfem::Patch& patch, PatchSurface& surface);

/// One tool between ticks.
struct ToolMemory {
  Pose pose;                      // of the last tick
  bool seen = false;              // pose is one
  bool inside = false;            // see ToolForce
  bool touching = false;          // bore force in the last tick
  Vec3d force_rest, torque_rest;  // left of a jump that is being blended away (follow.hpp) [N] [N·m]
};

/// What changes.
struct TouchState {
  TouchParams params;
  PatchSurface surface;
  std::vector<Vec3d> x;      // points after the last tick [m]
  std::vector<Vec3d> u;      // x − rest − offset [m]
  std::vector<Vec3d> force;  // on each point [N]
  std::vector<Vec3d>
      offset;  // displacement that no force of ours makes; zero unless the caller writes it [m]
  ViscousHistory history;
  std::vector<ToolMemory> tools;
  std::vector<Site> sites;  // of the last tick; the held ones first
  int held = 0;
  CoulombReport solution;  // of the last tick

  Coulomb problem;  // from here on, only of use within a tick
  std::vector<Site> candidates;
};

/// At rest. `largest_patch`: points that a later patch may have without an allocation.
TouchState make_touch_state(const sfem::Patch& patch, std::size_t tool_count, const TouchParams& params,
                            std::size_t largest_patch = 0);

/// One tick of `dt` seconds; a tick of 0 s repeats the last one. Poses and forces: one a tool.
void touch(const sfem::Patch& patch, TouchState& state, std::span<const Tool> tools,
           std::span<const ToolPose> poses, double dt, std::span<ToolForce> forces);

/// Contact pressure at every point: force along its normal at rest / area around it [Pa].
void contact_pressure(const TouchState& state, std::span<double> pressure);

}  // namespace turgor::contact
