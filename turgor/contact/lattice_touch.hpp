// Tools on a lattice. Tools touch samples of the displayed skin. Every outermost node has a sample at the
// skin point nearest to it. Two neighbor nodes share a sample halfway between their skin points. Before a
// step the samples near a tool become contacts of their nodes (lattice::NodeContact). After the step their
// forces are summed to the force on the tool. One step is one frame, so forces are updated at the frame rate.
// In a body with partial cells on the host, samples move with the cells that contain them, and contacts act
// there (lattice::ContactPoints): its outermost nodes lie below the surface that bears.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/touch.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::contact {

using LatticeSample = lattice::SurfaceSample;

/// A sample near a tool, between two steps.
struct LatticeContact {
  int sample = 0, tool = 0;
  bool is_held = false;
  Vec3d anchor;  // position at which it is held, in the tool's frame [m]
  Vec3d force;   // on the sample, in the tool's axes [N]
};

struct LatticeTouch {
  std::vector<LatticeSample> samples;          // sorted by slot, wall and the other node's slot
  bool in_cells = false;                       // samples move with cells (TouchCarrier)
  std::vector<lattice::EmbeddedPoint> points;  // by sample: its cell; empty: samples move with nodes
  std::vector<std::uint8_t> is_far;            // by point: 1 = in a whole cell far from cuts
  std::vector<int> virtual_slots;              // with points: node of every virtual node
  std::uint64_t version = 0;                   // changes with every new list of samples
  std::vector<LatticeContact> contacts;        // ordered by sample, then by tool
  std::vector<ToolPose> poses;                 // at the end of the last step, lattice frame
  std::vector<lattice::NodeContact> nodes;     // of the last step, one per contact
  lattice::ContactPoints contact_points;       // of `nodes`, with points
};

/// Displacement of a sample [m].
inline Vec3d sample_displacement(const LatticeTouch& touch, const lattice::Motion& motion, int sample) {
  if (!touch.points.empty()) return Vec3d(displacement(touch.points[std::size_t(sample)], motion));
  return mean_at(touch.samples[std::size_t(sample)], [&](int slot) { return motion.u[std::size_t(slot)]; });
}
/// Velocity of a sample [m/s]. Virtual nodes have none: it is that of the other corners.
Vec3d sample_velocity(const LatticeTouch& touch, const lattice::Motion& motion, int sample);
/// Present position of a sample, lattice frame [m].
inline Vec3d sample_position(const LatticeTouch& touch, const lattice::Motion& motion, int sample) {
  return touch.samples[std::size_t(sample)].rest + sample_displacement(touch, motion, sample);
}
/// Contacts of a step as inputs of the solver.
inline void set_contacts(LatticeTouch& touch, lattice::Inputs& inputs) {
  inputs.contacts = touch.nodes;
  inputs.points = touch.points.empty() ? nullptr : &touch.contact_points;
}

/// Carrier of the samples of a body with partial cells. Contacts on a device act on nodes.
enum class TouchCarrier { kCells, kNodes };

/// Touch state with the tools at their first poses [patient frame]. `surface` has no cuts.
LatticeTouch make_lattice_touch(const lattice::Model& model, const lattice::Cuts& cuts,
                                const lattice::BodySurface& surface, std::span<const ToolPose> poses,
                                TouchCarrier carrier = TouchCarrier::kCells);
/// Replaces the samples after cuts changed the surface. Tools keep the tissue that they hold.
void update_surface(LatticeTouch& touch, const lattice::Model& model, const lattice::Cuts& cuts,
                    const lattice::BodySurface& surface);

/// Teleports a tool to a pose [patient frame]. The tool releases all of its contacts.
void teleport_tool(LatticeTouch& touch, const lattice::Model& model, int tool, const ToolPose& pose);

/// Samples that tools may reach on their paths to `poses` [patient frame], and samples in contact. Ascending.
std::vector<int> samples_near(const lattice::Model& model, const lattice::DeviceState& state,
                              const LatticeTouch& touch, std::span<const Tool> tools,
                              std::span<const ToolPose> poses);
std::vector<int> samples_near(const lattice::Model& model, const lattice::Motion& motion,
                              const LatticeTouch& touch, std::span<const Tool> tools,
                              std::span<const ToolPose> poses);
/// Nodes that carry the samples.
std::vector<int> nodes_of(const LatticeTouch& touch, std::span<const int> samples);

/// Finds the contacts of a step that moves the tools to `poses` [patient frame]; set_contacts. They are valid
/// until the next call. `near`: result of samples_near.
void find_contacts(const lattice::Model& model, const lattice::Motion& motion, LatticeTouch& touch,
                   std::span<const Tool> tools, std::span<const ToolPose> poses, double dt,
                   std::span<const int> near);
/// Reads the contact forces of the step, one force per tool. ToolForce::area stays 0.
void read_forces(const lattice::Model& model, const lattice::Motion& motion, LatticeTouch& touch,
                 std::span<const Tool> tools, std::span<ToolForce> forces);
/// Complete lattice step on the CPU: contacts, solver step, forces. `inputs` must not contain contacts. The
/// model's solver must be VBD.
lattice::StepReport step_with_tools(const Exec& exec, const lattice::Model& model, lattice::State& state,
                                    LatticeTouch& touch, std::span<const Tool> tools,
                                    std::span<const ToolPose> poses, lattice::Inputs inputs, double dt,
                                    std::span<ToolForce> forces);

}  // namespace turgor::contact
