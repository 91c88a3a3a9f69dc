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

double largest_displacement(const lattice::Motion& motion) {
  Real most = 0;
  for (std::size_t s = 0; s < motion.u.x.size(); s++) most = std::max(most, dot(motion.u[s], motion.u[s]));
  return std::sqrt(double(most));
}

/// Box around the cells near cuts, extended by the displacements of all nodes. Lattice frame [m].
Box box_of_cuts(const LatticeBody& body, const lattice::Fragments& fragments) {
  const Lattice& l = body.model.anatomy.lattice;
  std::vector<Vec3d> corners;
  for (const lattice::CutCell& cell : fragments.cells) {
    const Int3 low = slot_node(l, cell.slot);
    corners.emplace_back(rest_position(l, low));
    corners.emplace_back(rest_position(l, low + Int3{1, 1, 1}));
  }
  const double most = largest_displacement(body.state->motion);
  Box box = box_around(corners);
  box.low -= Vec3d{most, most, most}, box.high += Vec3d{most, most, most};
  return box;
}

/// True if tool `t` may reach a wall of a cut on its path to its pose.
bool may_reach_cuts(const LatticeBody& body, const Box& cuts, std::size_t t) {
  const Grid& grid = body.model.anatomy.grid;
  const Vec3d at = inverse(grid.axes) * (body.poses[t].pose.position - grid.origin);
  const Vec3 h = body.model.anatomy.lattice.spacing;
  const double reach = contact::bounding_radius(body.tools[t].shape) + double(std::max({h.x, h.y, h.z})) +
                       norm(at - body.touch.poses[t].pose.position);
  return squared_distance(cuts, at) <= reach * reach;
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

bool needs_surface(const LatticeBody& body) {
  const lattice::Cuts& cuts = body.state.cuts();
  if (body.rest.empty()) return true;
  if (body.surface_cuts == cut_version(cuts)) return false;
  if (body.surface_cuts > cut_version(cuts)) return true;  // of a cut that was undone
  const auto is_needle = [](const contact::Tool& tool) { return tool.needle.has_value(); };
  if (body.haptic.empty() || body.state.is_on_device() || !body.touch.contacts.empty() ||
      std::any_of(body.tools.begin(), body.tools.end(), is_needle))
    return true;
  // cells near cuts are known, and no tissue left the body; rim nodes that a cut has loosened were no tissue
  if (!cuts.fragments || cuts.fragments->version != cut_version(cuts) || cuts.fragments->cells.empty() ||
      cuts.removed_nodes > 0)
    return true;
  // samples of the skin, and walls of the cuts
  if (!contact::samples_near(body.model, body.state, body.touch, body.tools, body.poses).empty()) return true;
  const Box walls = box_of_cuts(body, *cuts.fragments);
  for (std::size_t t = 0; t < body.tools.size(); t++)
    if (may_reach_cuts(body, walls, t) ||
        (body.rest_skin.at && is_below(body.rest_skin, body.tools[t], body.poses[t].pose, 0)))
      return true;
  return false;
}

Status begin_body(const Exec&, LatticeBody& body, const LatticeScene&, const World& world) {
  const std::vector<TouchingTool>& tools = world.tools;
  for (const int t : body.tool_indices) body.tools.push_back(tools[std::size_t(t)].tool);
  if (body.tools.empty()) return Done{};
  body.poses.resize(body.tools.size());
  body.forces.resize(body.tools.size());
  set_poses(body, tools, 0);
  body.touch = contact::make_lattice_touch(
      body.model, body.state.cuts(), body.surface, body.poses,
      body.state.has_device() ? contact::TouchCarrier::kNodes : contact::TouchCarrier::kCells);
  if (!body.surface.triangles.empty())
    body.rest_skin = distance_to_surface(mesh_of(body.rest, body.surface.triangles));
  begin_needles(body);
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
  for (std::size_t t = 0; t < body.haptic.size(); t++) {
    if (!body.haptic[t].was_teleported) continue;
    contact::teleport_tool(body.touch, body.model, int(t), body.poses[t]);
    if (body.tools[t].needle) contact::release_needle(body.needles[t]), body.needles[t].seen = false;
  }
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
    if (const std::optional<contact::Needle>& needle = body.tools[t].needle) {
      const double moved = norm(body.poses[t].pose.position - before[t].pose.position);
      substeps = std::max(substeps, moved / needle->spacing);
      continue;
    }
    substeps = std::max(substeps, contact::motion(shape, before[t].pose, body.poses[t].pose) /
                                      (kLargestMotion * contact::tip_radius(shape)));
  }
  TURGOR_CHECK(substeps >= 1, "a frame has at least one substep");
  return int(std::ceil(std::min(substeps, double(kMostSubsteps))));
}

void find_tool_contacts(LatticeBody& body, double dt, lattice::Inputs& inputs) {
  const std::vector<int> near =
      contact::samples_near(body.model, body.state, body.touch, body.tools, body.poses);
  body.state.read_nodes(nodes_of(body.touch, near), [&](const lattice::State& state) {
    contact::find_contacts(body.model, state.motion, body.touch, body.tools, body.poses, dt, near);
  });
  contact::set_contacts(body.touch, inputs);
}

void read_tool_forces(LatticeBody& body) {
  body.state.read_nodes(touched_nodes(body), [&](const lattice::State& state) {
    contact::read_forces(body.model, state.motion, body.touch, body.tools, body.forces);
  });
  read_needle_forces(body);
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
    if (tool.needle || passed_at || body.forces[t].contacts > 0) continue;
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
    add_needle(body, t, sample, tools[std::size_t(body.tool_indices[t])]);
    tools[std::size_t(body.tool_indices[t])].samples.append(sample);
  }
}

void publish_contacts(LatticeBody& body) {
  if (body.haptic.empty()) return;
  body.state.read_nodes(touched_nodes(body), [&](const lattice::State& state) {
    for (std::size_t t = 0; t < body.haptic.size(); t++) {
      const std::optional<contact::Needle>& needle = body.tools[t].needle;
      publish_contact(body, t,
                      needle ? contact::local_contact(body.model, *needle, body.needles[t])
                             : contact::local_contact(body.model, state.motion, body.touch, int(t),
                                                      body.tools[t], body.poses[t], body.haptic[t].history));
    }
  });
}

}  // namespace turgor
