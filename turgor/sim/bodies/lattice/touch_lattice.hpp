// Tools on a lattice body during a frame: poses, contacts, forces and samples. Contacts are found once a
// substep; haptic ticks use their planes until the next frame.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct LatticeBody;

/// Sets all tools to their commands at a time [s].
void set_poses(LatticeBody& body, const std::vector<TouchingTool>& tools, double time);
/// Moves teleported tools to their start of this step; `from`: its time [s].
void teleport_tools(LatticeBody& body, const std::vector<TouchingTool>& tools, double from);
/// Number of substeps in each of which no tool moves farther than half of its tip radius, at most 8.
int substep_count(LatticeBody& body, const std::vector<TouchingTool>& tools, double from, double to);

/// True if a tool may touch the body at the present poses while its surface is older than the latest cut. The
/// contacts of such a frame need the surface; without any, the state of the body does not depend on it.
bool needs_surface(const LatticeBody& body);

/// Adds the contacts at the present poses to the inputs of a step of `dt` [s]. They are valid until the next
/// call.
void find_tool_contacts(LatticeBody& body, double dt, lattice::Inputs& inputs);
/// Reads the tools' forces of the last step.
void read_tool_forces(LatticeBody& body);
/// Records the time at which a tool is first farther below the present surface than contact lets it.
void note_passed_tools(const LatticeBody& body, std::vector<TouchingTool>& tools, double time);
/// Appends a sample to the log of every tool; `seconds`: wall time of the step.
void record_step(const LatticeBody& body, std::vector<TouchingTool>& tools, double time, double seconds);
/// Publishes contact planes for the ticks until the next frame.
void publish_contacts(LatticeBody& body);

}  // namespace turgor
