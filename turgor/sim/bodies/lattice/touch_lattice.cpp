#include "turgor/sim/bodies/lattice/touch_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/contact/tips.hpp"
#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/live/exchanges.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Surface at the end of the last step.
TriMesh present_surface(const LatticeBody& body) {
  std::vector<int> nodes;
  if (body.state.is_on_device())
    nodes = lattice::support_nodes(body.model, body.state.cuts(), body.state.virtual_u(), body.surface);
  return body.state.read_wound_nodes(nodes, [&](const lattice::State& state) {
    return lattice::deformed_surface(body.model, state, body.surface, lattice::Shown::kNothing);
  });
}

/// True if a test point of the tool is deeper than `depth` below a surface.
bool is_below(const SignedDistance& surface, const contact::Tool& tool, const contact::Pose& pose,
              double depth) {
  const Box box{surface.low, surface.high};
  bool below = false;
  contact::visit_tips(tool.shape, pose, contact::kAllTips, [&](Vec3d point, Vec3d) {
    below = below || (squared_distance(box, point) == 0 && surface.at(point) < -depth);
  });
  return below;
}

/// Nodes that carry the contact samples of the last step.
std::vector<int> touched_nodes(const LatticeBody& body) {
  std::vector<int> samples;
  for (const contact::LatticeContact& contact : body.touch.contacts) samples.push_back(contact.sample);
  return nodes_of(body.touch, samples);
}

void make_surface(const Exec& exec, LatticeBody& body) {
  body.surface = lattice::build_surface(body.model, body.state.cuts(), &body.ct, lattice::Extent::kAll, exec,
                                        &body.meshed);
  body.rest = lattice::rest_points(body.model, body.surface);
  body.surface_cuts = cut_version(body.state.cuts());
}

}  // namespace

void refresh_surface(const Exec& exec, LatticeBody& body) {
  const bool made = !body.rest.empty();
  if (made && cut_version(body.state.cuts()) == body.surface_cuts) return;
  make_surface(exec, body);
  if (made && !body.tools.empty())
    contact::update_surface(body.touch, body.model, body.state.cuts(), body.surface);
}

Status begin_body(const Exec&, LatticeBody& body, const LatticeScene&, const World& world) {
  const std::vector<TouchingTool>& tools = world.tools;
  for (const int t : body.tool_indices) body.tools.push_back(tools[std::size_t(t)].tool);
  if (body.tools.empty()) return Done{};
  body.poses.resize(body.tools.size());
  body.forces.resize(body.tools.size());
  set_poses(body, tools, 0);
  body.touch = contact::make_lattice_touch(body.model, body.state.cuts(), body.surface, body.poses);
  if (!body.surface.triangles.empty())
    body.rest_skin = distance_to_surface(mesh_of(body.rest, body.surface.triangles));
  return Done{};
}

void set_poses(LatticeBody& body, const std::vector<TouchingTool>& tools, double time) {
  TURGOR_CHECK(body.poses.size() == body.tool_indices.size(), "one pose a tool");
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const contact::ToolCommand command = command_at(tools[std::size_t(body.tool_indices[t])], time);
    body.poses[t] = {command.pose, command.hold};
  }
}

void teleport_tools(LatticeBody& body, const std::vector<TouchingTool>& tools, double from) {
  set_poses(body, tools, from);
  for (std::size_t t = 0; t < body.haptic.size(); t++)
    if (body.haptic[t].was_teleported) contact::teleport_tool(body.touch, body.model, int(t), body.poses[t]);
}

int substep_count(LatticeBody& body, const std::vector<TouchingTool>& tools, double from, double to) {
  constexpr double kLargestMotion = 0.5;
  constexpr int kMostSubsteps = 8;

  // poses at both ends
  set_poses(body, tools, from);
  const std::vector<contact::ToolPose> before = body.poses;
  set_poses(body, tools, to);

  // largest motion of a tool, relative to its radius
  double substeps = 1;
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    const contact::Shape& shape = body.tools[t].shape;
    substeps = std::max(substeps, contact::motion(shape, before[t].pose, body.poses[t].pose) /
                                      (kLargestMotion * contact::tip_radius(shape)));
  }
  TURGOR_CHECK(substeps >= 1, "a frame has at least one substep");
  return int(std::ceil(std::min(substeps, double(kMostSubsteps))));
}

std::span<lattice::NodeContact> find_tool_contacts(LatticeBody& body, double dt) {
  const std::vector<int> near =
      contact::samples_near(body.model, body.state, body.touch, body.tools, body.poses);
  return body.state.read_nodes(nodes_of(body.touch, near), [&](const lattice::State& state) {
    return contact::find_contacts(body.model, state.motion, body.touch, body.tools, body.poses, dt, near);
  });
}

void read_tool_forces(LatticeBody& body) {
  body.state.read_nodes(touched_nodes(body), [&](const lattice::State& state) {
    contact::read_forces(body.model, state.motion, body.touch, body.tools, body.forces);
  });
}

// Contact keeps the skin out of a tool within about one spacing, the distance between its samples.
void note_passed_tools(const LatticeBody& body, std::vector<TouchingTool>& tools, double time) {
  const Vec3 h = body.model.anatomy.lattice.spacing;
  const double reach = double(std::max({h.x, h.y, h.z}));
  std::optional<SignedDistance> now;
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    // the present surface takes as long as a step: it is made only for a tool that touches nothing below the
    // surface at rest
    std::optional<double>& passed_at = tools[std::size_t(body.tool_indices[t])].limits.passed_at;
    const contact::Tool& tool = body.tools[t];
    const contact::Pose& pose = body.poses[t].pose;
    if (passed_at || body.forces[t].contacts > 0) continue;
    if (!body.rest_skin.at || !is_below(body.rest_skin, tool, pose, 0)) continue;
    if (!now) now = distance_to_surface(present_surface(body));
    if (is_below(*now, tool, pose, reach)) passed_at = time;
  }
}

void record_step(const LatticeBody& body, std::vector<TouchingTool>& tools, double time, double seconds) {
  TURGOR_CHECK(body.forces.size() == body.tool_indices.size(), "one force a tool");
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const contact::ToolForce& haptic = body.forces[t];
    contact::ToolReading reading{.force = haptic.force, .torque = haptic.torque, .contacts = haptic.contacts};
    if (body.rest_skin.at)
      reading.depth =
          contact::depth_in(body.rest_skin, body.tools[t].shape, body.poses[t].pose, contact::kAllTips);
    ForceSample sample = sample_of(time, {.pose = body.poses[t].pose, .hold = body.poses[t].hold}, reading);
    sample.tick_seconds = float(seconds);
    tools[std::size_t(body.tool_indices[t])].samples.append(sample);
  }
}

void publish_contacts(LatticeBody& body) {
  if (body.haptic.empty()) return;
  body.state.read_nodes(touched_nodes(body), [&](const lattice::State& state) {
    for (std::size_t t = 0; t < body.haptic.size(); t++)
      publish_contact(body, t,
                      contact::local_contact(body.model, state.motion, body.touch, int(t), body.tools[t],
                                             body.poses[t], body.haptic[t].history));
  });
}

}  // namespace turgor
