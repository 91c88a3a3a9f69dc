// Stages of one haptic tick and their common data. touch.cpp calls the stages in this order.
#pragma once

#include "turgor/contact/touch.hpp"

namespace turgor::contact {

/// One tick. A tick with a fast tool is split into substeps.
struct Tick {
  const sfem::Patch& patch;
  TouchState& state;
  std::span<const Tool> tools;
  std::span<const ToolPose> poses;  // at the end of the tick
  std::span<ToolForce> forces;
  ViscousTick viscous;
  double fraction = 1;  // end of this substep, as a fraction of the motion since the last tick

  Pose pose(std::size_t tool) const;
  DeformedSurface deformed() const { return {patch, state.surface, state.x, state.outward}; }
};

/// Upper bound of the displacement of any point of the tool between two poses [m].
double motion(const Shape& shape, const Pose& from, const Pose& to);
/// Largest depth of a surface point inside a tool [m].
double largest_penetration(const Tick& tick, std::size_t tool, const Pose& pose);

/// Handles invalid poses, tools that appear and tools that jump. Returns the number of substeps.
int prepare_poses(Tick& tick);
/// Fills TouchState::new_sites, held sites first.
void find_sites_of_all_tools(Tick& tick);
/// Solves for the forces of the sites.
void solve_sites(Tick& tick);

}  // namespace turgor::contact
