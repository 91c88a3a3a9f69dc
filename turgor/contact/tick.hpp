// The steps of one haptic tick, which touch.cpp runs in this order, and what all of them need.
#pragma once

#include "turgor/contact/touch.hpp"

namespace turgor::contact {

/// One tick, or a part of one when a tool is fast.
struct Tick {
  const sfem::Patch& patch;
  TouchState& state;
  std::span<const Tool> tools;
  std::span<const ToolPose> poses;  // of the end of the tick
  std::span<ToolForce> forces;
  ViscousTick viscous;
  double part = 1;  // of the way from the last tick's poses

  Pose pose(std::size_t tool) const;
  DeformedSurface lie() const { return {patch, state.surface, state.x, state.outward}; }
};

/// No point of the tool moves farther than this from one pose to the other [m].
double motion(const Shape& shape, const Pose& from, const Pose& to);
/// Of the deepest point of the surface in a tool [m].
double largest_penetration(const Tick& tick, std::size_t tool, const Pose& pose);

/// Sorts out poses that are not valid, tools that appear and tools that jump; returns how many parts this
/// tick takes.
int look_at_poses(Tick& tick);
/// Fills TouchState::new_sites, the held ones first.
void find_all_sites(Tick& tick);
/// Their forces.
void solve_sites(Tick& tick);

}  // namespace turgor::contact
