// Tools on a lattice. Places on the drawn skin are what they touch: the nearest one to every outermost node,
// and one halfway between any two of those, which both bear. Before a step the places near a tool become
// contacts of their nodes (lattice::NodeContact), and after it their forces become that on the tool. One step
// is one frame: forces come at the frame rate.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/touch.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::contact {

using LatticePlace = lattice::SurfaceSample;

/// A place near a tool, between steps.
struct LatticeContact {
  int place = 0, tool = 0;
  bool is_held = false;
  Vec3d anchor;  // where it is held, in the tool's frame [m]
  Vec3d force;   // on the place, along the tool's axes [N]
};

struct LatticeTouch {
  std::vector<LatticePlace> places;         // by slot, wall and other
  std::uint64_t version = 0;                // of the places, another one for every list of them
  std::vector<LatticeContact> contacts;     // by place, then by tool
  std::vector<ToolPose> poses;              // of the end of the last step, lattice frame
  std::vector<lattice::NodeContact> nodes;  // of the last step, one a contact
};

/// Of a field, at a place.
inline Vec3d mean_of(const lattice::VecField& field, const LatticePlace& place) {
  return mean_at(place, [&](int slot) { return field[std::size_t(slot)]; });
}
/// Where a place is now, lattice frame [m].
inline Vec3d place_now(const lattice::State& state, const LatticePlace& place) {
  return place.rest + mean_of(state.u, place);
}

/// Tools at their first poses [patient frame]. `surface` without cuts.
LatticeTouch make_lattice_touch(const lattice::Model& model, const lattice::State& state,
                                const lattice::BodySurface& surface, std::span<const ToolPose> poses);
/// The surface was built anew: there are new cuts. What tools hold, they still hold.
void take_surface(LatticeTouch& touch, const lattice::Model& model, const lattice::State& state,
                  const lattice::BodySurface& surface);

/// A tool is elsewhere [patient frame], without a way there: it lets go of all that it touched.
void teleport_tool(LatticeTouch& touch, const lattice::Model& model, int tool, const ToolPose& pose);

/// The places that tools may come to on their way to `poses` [patient frame] or have hold of, ascending.
std::vector<int> places_near(const lattice::Model& model, const lattice::DeviceState& state,
                             const LatticeTouch& touch, std::span<const Tool> tools,
                             std::span<const ToolPose> poses);
std::vector<int> places_near(const lattice::Model& model, const lattice::State& state,
                             const LatticeTouch& touch, std::span<const Tool> tools,
                             std::span<const ToolPose> poses);
/// The nodes that carry them.
std::vector<int> nodes_of(const LatticeTouch& touch, std::span<const int> places);

/// The contacts of a step in which the tools go to `poses` [patient frame], for lattice::Inputs; valid until
/// they are found for the next one. `near`: places_near.
std::span<lattice::NodeContact> find_contacts(const lattice::Model& model, const lattice::State& state,
                                              LatticeTouch& touch, std::span<const Tool> tools,
                                              std::span<const ToolPose> poses, double dt,
                                              std::span<const int> near);
/// What they became in the step: one force a tool; its area stays 0.
void read_forces(const lattice::Model& model, const lattice::State& state, LatticeTouch& touch,
                 std::span<const Tool> tools, std::span<ToolForce> forces);
/// That step, between the two, on the CPU; `inputs` without contacts. The model's solver must be descent.
lattice::StepReport step(const Exec& exec, const lattice::Model& model, lattice::State& state,
                         LatticeTouch& touch, std::span<const Tool> tools, std::span<const ToolPose> poses,
                         lattice::Inputs inputs, double dt, std::span<ToolForce> forces);

}  // namespace turgor::contact
