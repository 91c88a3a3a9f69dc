#include "turgor/contact/lattice_touch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/contact/lattice_points.hpp"
#include "turgor/contact/lattice_samples.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::contact {

namespace {

ToolPose in_lattice(const Grid& grid, const ToolPose& pose) {
  const Mat3d to_lattice = inverse(grid.axes);
  ToolPose local = pose;
  local.pose.position = to_lattice * (pose.pose.position - grid.origin);
  for (Vec3d& axis : local.pose.axes.column) axis = to_lattice * axis;
  return local;
}

std::vector<ToolPose> in_lattice(const Grid& grid, std::span<const ToolPose> poses) {
  std::vector<ToolPose> local;
  for (const ToolPose& pose : poses) local.push_back(in_lattice(grid, pose));
  return local;
}

/// Distance from a tool within which samples become contacts [m].
double contact_reach(const lattice::Model& model) {
  const Vec3 h = model.anatomy.lattice.spacing;
  return std::max({h.x, h.y, h.z});
}
/// Balls that contain the path of each tool from its last pose to the new one [lattice frame].
std::vector<lattice::Ball> balls_around(const lattice::Model& model, const LatticeTouch& touch,
                                        std::span<const Tool> tools, std::span<const ToolPose> to) {
  TURGOR_ASSERT(tools.size() == to.size() && tools.size() == touch.poses.size(), "one pose a tool");
  std::vector<lattice::Ball> balls;
  for (std::size_t t = 0; t < tools.size(); t++) {
    const double displacement = norm(to[t].pose.position - touch.poses[t].pose.position);
    const double reach = bounding_radius(tools[t].shape) + contact_reach(model) + displacement;
    balls.push_back({to[t].pose.position, tools[t].needle ? 0 : reach});  // a needle has no contacts
  }
  return balls;
}

std::vector<int> with_contact_samples(const LatticeTouch& touch, std::vector<int> near) {
  for (const LatticeContact& contact : touch.contacts) near.push_back(contact.sample);
  sort_unique(near);
  return near;
}

bool comes_before(const LatticeContact& a, const LatticeContact& b) {
  return a.sample != b.sample ? a.sample < b.sample : a.tool < b.tool;
}

/// Motion of one tool in a step.
struct ToolStep {
  const Tool& tool;
  const ToolPose &from, &to;
  lattice::Ball around;  // samples beyond it cannot come into contact
};

/// Turns the samples near the tools into contacts of a step. The contact plane is the tool's tangent plane at
/// its new pose, seen from the sample's predicted position. A sticking sample moves with the tool.
struct FindContacts {
  const lattice::Model& model;
  const lattice::Motion& motion;
  LatticeTouch& touch;
  double reach = 0;  // distance from a tool within which samples become contacts [m]
  double dt = 0;

  void add(int p, int t, const ToolStep& s, const LatticeContact& before) const {
    // hold: begins at a sample that bears force, ends with the command
    TURGOR_CHECK(is_index(p, touch.samples.size()), "a contact refers to a sample of the surface");
    const LatticeSample& sample = touch.samples[std::size_t(p)];
    const Vec3d x = sample_position(touch, motion, p), local = to_tool(s.from.pose, x);
    LatticeContact contact{p, t, before.is_held, before.anchor, before.force};
    if (!s.to.hold) contact.is_held = false;
    if (s.to.hold && !s.from.hold && norm(before.force) > 0) contact.is_held = true, contact.anchor = local;
    // predicted position of the sample, and of its anchor on the tool
    const Vec3d carried = to_world(s.to.pose, contact.is_held ? contact.anchor : local);
    const Vec3d predicted = x + sample_velocity(touch, motion, p) * dt;
    const ShapeDistance d = distance(s.tool.shape, s.to.pose, predicted);
    if (d.distance > reach && !contact.is_held) return;
    // contact of the node: tangent plane and target
    const bool at_point = !touch.points.empty();
    const lattice::CornerNodes nodes{model, touch.virtual_slots};
    const int leader = at_point ? leading_corner(nodes, touch.points[std::size_t(p)]) : sample.slot;
    if (leader < 0) return;
    lattice::NodeContact node{.slot = nodes.slot(leader),
                              .other = at_point ? -1 : sample.other,
                              .normal = Vec3(d.normal),
                              .friction = Real(s.tool.friction),
                              .is_held = contact.is_held,
                              .force = Vec3(s.to.pose.axes * contact.force)};
    const Vec3d surface_point = predicted - d.normal * d.distance;
    const Vec3d target =
        contact.is_held ? carried : carried + d.normal * dot(d.normal, surface_point - carried);
    node.target = Vec3(target - sample.rest);
    touch.nodes.push_back(node);
    if (at_point) {
      touch.contact_points.at.push_back(touch.points[std::size_t(p)]);
      touch.contact_points.leader.push_back(leader);
    }
    touch.contacts.push_back(contact);
  }

  // match samples and tools with the contacts of the last step
  void operator()(std::span<const ToolStep> steps, std::span<const int> near) const {
    TURGOR_CHECK(is_ascending(near), "samples near the tools ascend");
    TURGOR_CHECK(std::is_sorted(touch.contacts.begin(), touch.contacts.end(), comes_before),
                 "contacts ascend by sample and tool");
    // merge with the previous contacts, which ascend by the same key
    const std::vector<LatticeContact> before = std::move(touch.contacts);
    auto previous = before.begin();
    touch.contacts.clear(), touch.nodes.clear();
    touch.contact_points.at.clear(), touch.contact_points.leader.clear();
    for (const int p : near) {
      const Vec3d x = sample_position(touch, motion, p);
      for (std::size_t t = 0; t < steps.size(); t++) {
        // find the previous contact of this sample and tool
        LatticeContact contact{.sample = p, .tool = int(t)};
        while (previous != before.end() && comes_before(*previous, contact)) ++previous;
        const bool is_known = previous != before.end() && !comes_before(contact, *previous);
        // keep known contacts and add those inside the tool's bounds
        if (is_known || contains(steps[t].around, x))
          add(p, int(t), steps[t], is_known ? *previous : contact);
      }
    }
  }
};

}  // namespace

Vec3d sample_velocity(const LatticeTouch& touch, const lattice::Motion& motion, int sample) {
  const auto at = [&](int slot) { return motion.v[std::size_t(slot)]; };
  if (touch.points.empty()) return mean_at(touch.samples[std::size_t(sample)], at);
  const lattice::EmbeddedPoint& point = touch.points[std::size_t(sample)];
  const int slots = int(motion.v.x.size());
  Vec3d sum;
  double weights = 0;
  for (std::size_t c = 0; c < 8; c++)
    if (point.corner[c] < slots)
      sum += Vec3d(at(point.corner[c])) * double(point.weight[c]), weights += double(point.weight[c]);
  return weights > 0.1 ? sum / weights : Vec3d{};
}

LatticeTouch make_lattice_touch(const lattice::Model& model, const lattice::Cuts& cuts,
                                const lattice::BodySurface& surface, std::span<const ToolPose> poses,
                                TouchCarrier carrier) {
  LatticeTouch touch;
  touch.in_cells = carrier == TouchCarrier::kCells && !model.anatomy.cell_center.empty();
  touch.samples = skin_samples(model, surface);
  for (const ToolPose& pose : poses) touch.poses.push_back(in_lattice(model.anatomy.grid, pose));
  update_surface(touch, model, cuts, surface);
  return touch;
}

void teleport_tool(LatticeTouch& touch, const lattice::Model& model, int tool, const ToolPose& pose) {
  TURGOR_ASSERT(is_index(tool, touch.poses.size()), "a teleported tool belongs to the touch");
  touch.poses[std::size_t(tool)] = in_lattice(model.anatomy.grid, pose);
  std::erase_if(touch.contacts, [tool](const LatticeContact& contact) { return contact.tool == tool; });
}

std::vector<int> samples_near(const lattice::Model& model, const lattice::DeviceState& state,
                              const LatticeTouch& touch, std::span<const Tool> tools,
                              std::span<const ToolPose> poses) {
  if (!touch.points.empty()) return samples_near(model, state->motion, touch, tools, poses);
  const std::vector<lattice::Ball> balls =
      balls_around(model, touch, tools, in_lattice(model.anatomy.grid, poses));
  return with_contact_samples(touch, state.samples_in_balls(touch.samples, touch.version, balls));
}
std::vector<int> samples_near(const lattice::Model& model, const lattice::Motion& motion,
                              const LatticeTouch& touch, std::span<const Tool> tools,
                              std::span<const ToolPose> poses) {
  const std::vector<lattice::Ball> balls =
      balls_around(model, touch, tools, in_lattice(model.anatomy.grid, poses));
  if (touch.points.empty())
    return with_contact_samples(touch, samples_in_balls(touch.samples, motion, balls));
  std::vector<int> found;
  for (int p = 0; p < int(touch.samples.size()); p++) {
    const Vec3d x = sample_position(touch, motion, p);
    if (std::any_of(balls.begin(), balls.end(), [&](const lattice::Ball& ball) { return contains(ball, x); }))
      found.push_back(p);
  }
  return with_contact_samples(touch, std::move(found));
}

std::vector<int> nodes_of(const LatticeTouch& touch, std::span<const int> samples) {
  TURGOR_CHECK(all_indices(samples, touch.samples.size()), "samples belong to the surface");
  std::vector<int> nodes;
  for (const int p : samples) {
    const LatticeSample& sample = touch.samples[std::size_t(p)];
    nodes.push_back(sample.slot);
    if (sample.other >= 0) nodes.push_back(sample.other);
  }
  return nodes;
}

void find_contacts(const lattice::Model& model, const lattice::Motion& motion, LatticeTouch& touch,
                   std::span<const Tool> tools, std::span<const ToolPose> poses, double dt,
                   std::span<const int> near) {
  TURGOR_ASSERT(is_step_length(dt), "contacts are found for a step of positive length");
  TURGOR_CHECK(motion.u.x.size() == model.anatomy.inverse_mass.size(),
               "positions are on the host while contacts are found");
  std::vector<ToolPose> to = in_lattice(model.anatomy.grid, poses);
  const std::vector<lattice::Ball> balls = balls_around(model, touch, tools, to);
  std::vector<ToolStep> steps;
  for (std::size_t t = 0; t < tools.size(); t++) steps.push_back({tools[t], touch.poses[t], to[t], balls[t]});
  FindContacts{model, motion, touch, contact_reach(model), dt}(steps, near);
  touch.poses = std::move(to);
  if (!touch.points.empty())
    make_terms(lattice::CornerNodes{model, touch.virtual_slots}, touch.contact_points);
}

/// Sets the contacts' forces for the next step and sums the tools' forces in the patient frame.
void read_forces(const lattice::Model& model, const lattice::Motion& motion, LatticeTouch& touch,
                 std::span<const Tool> tools, std::span<ToolForce> forces) {
  TURGOR_ASSERT(tools.size() == forces.size(), "one force a tool");
  TURGOR_CHECK(touch.contacts.size() == touch.nodes.size(), "every contact has a node in the step");
  for (ToolForce& force : forces) force = {};
  for (std::size_t c = 0; c < touch.contacts.size(); c++) {
    LatticeContact& contact = touch.contacts[c];
    const lattice::NodeContact& node = touch.nodes[c];
    const Pose& pose = touch.poses[std::size_t(contact.tool)].pose;
    // force in the tool's axes, for the next step
    const Vec3d x = sample_position(touch, motion, contact.sample), force(node.force);
    for (int axis = 0; axis < 3; axis++) contact.force[axis] = dot(pose.axes.column[axis], force);
    // penetration
    ToolForce& tool_force = forces[std::size_t(contact.tool)];
    const double outside = distance(tools[std::size_t(contact.tool)].shape, pose, x).distance;
    if (!contact.is_held) tool_force.largest_penetration = std::max(tool_force.largest_penetration, -outside);
    // sliding: tangential force at the friction limit
    if (!(norm(force) > 0)) continue;
    tool_force.contacts++;
    const double normal_force = dot(Vec3d(node.normal), force);
    const double tangential = norm(force - Vec3d(node.normal) * normal_force);
    // sum in the patient frame
    if (!contact.is_held && tangential > double(node.friction) * normal_force * (1 - 1e-4))
      tool_force.sliding++;
    const Vec3d on_tool = model.anatomy.grid.axes * -force,
                arm = model.anatomy.grid.axes * (x - pose.position);
    tool_force.force += on_tool;
    tool_force.torque += cross(arm, on_tool);
  }
}

lattice::StepReport step_with_tools(const Exec& exec, const lattice::Model& model, lattice::State& state,
                                    LatticeTouch& touch, std::span<const Tool> tools,
                                    std::span<const ToolPose> poses, lattice::Inputs inputs, double dt,
                                    std::span<ToolForce> forces) {
  const std::vector<int> near = samples_near(model, state.motion, touch, tools, poses);
  find_contacts(model, state.motion, touch, tools, poses, dt, near);
  set_contacts(touch, inputs);
  const lattice::StepReport report = lattice::step(exec, model, state, inputs, dt);
  read_forces(model, state.motion, touch, tools, forces);
  return report;
}

}  // namespace turgor::contact
