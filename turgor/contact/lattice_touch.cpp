#include "turgor/contact/lattice_touch.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>
#include <utility>

#include "turgor/contact/lattice_points.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"

namespace turgor::contact {

namespace {

/// True when a node is at the tissue's boundary: next to air, or at the border of the scan.
bool is_outermost(const lattice::Model& model, Int3 node) {
  for (int n = 0; n < lattice::kNeighborCount; n++) {
    const Int3 other = node + lattice::neighbor_offset(n);
    if (!contains(model.anatomy.lattice, other)) return true;
    if (!is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, other))])) return true;
  }
  return false;
}

/// An outermost node and the nearest point of the displayed skin.
struct NodeSkinPoint {
  int slot = 0;
  Int3 node;
  Vec3d position;  // lattice frame [m]
};
std::vector<NodeSkinPoint> skin_points_of_nodes(const lattice::Model& model, const TriangleTree& skin) {
  std::vector<NodeSkinPoint> skin_points;
  const Int3 size = model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        // outermost nodes of the body
        const Int3 node{i, j, k};
        const int slot = node_slot(model.anatomy.lattice, node);
        if (!is_body(model.anatomy.tissue[std::size_t(slot)]) || !is_outermost(model, node)) continue;
        const Vec3d rest(rest_position(model.anatomy.lattice, node));
        skin_points.push_back({slot, node, nearest_point(skin, rest).position});
      }
  std::sort(skin_points.begin(), skin_points.end(),
            [](const NodeSkinPoint& a, const NodeSkinPoint& b) { return a.slot < b.slot; });
  return skin_points;
}

/// Adds samples halfway between the skin points of neighboring nodes, where a tool would sink in. Neighbors
/// above each other share one skin point, so close pairs are skipped.
void add_samples_between(const lattice::Model& model, const TriangleTree& skin,
                         const std::vector<NodeSkinPoint>& skin_points, std::vector<LatticeSample>& samples) {
  TURGOR_CHECK(is_sorted_unique(skin_points, &NodeSkinPoint::slot), "skin points ascend by node");
  const Vec3 h = model.anatomy.lattice.spacing;
  const double nearest = 0.5 * double(std::min({h.x, h.y, h.z}));
  for (const NodeSkinPoint& point : skin_points)
    for (const Int3 family : kFamilies) {
      // neighbor of the same surface
      const Int3 node = point.node + family;
      if (!contains(model.anatomy.lattice, node)) continue;
      const int slot = node_slot(model.anatomy.lattice, node);
      const auto other = std::lower_bound(skin_points.begin(), skin_points.end(), slot,
                                          [](const NodeSkinPoint& f, int sought) { return f.slot < sought; });
      if (other == skin_points.end() || other->slot != slot) continue;
      // skip pairs that are close
      if (!(norm(other->position - point.position) > nearest)) continue;
      // sample at the middle, carried by both nodes
      const Vec3d rest = nearest_point(skin, (point.position + other->position) * 0.5).position;
      samples.push_back({point.slot, rest, false, slot});
      samples.push_back({slot, rest, false, point.slot});
    }
}

/// Samples of the skin at rest, without cuts: one for every node with skin, and one between any two
/// neighbors.
std::vector<LatticeSample> skin_samples(const lattice::Model& model, const lattice::BodySurface& surface) {
  std::vector<LatticeSample> samples;
  if (surface.skin_triangles == 0) return samples;
  TURGOR_CHECK(surface.skin_triangles > 0 && std::size_t(surface.skin_triangles) <= surface.triangles.size(),
               "triangles of the skin come before those of the walls");
  // search tree of the skin's triangles
  const auto triangles = surface.triangles.begin();
  const TriangleTree skin = build_triangle_tree({surface.rest.begin(), surface.rest.end()},
                                                {triangles, triangles + surface.skin_triangles});
  // samples at nodes and between them
  const std::vector<NodeSkinPoint> skin_points = skin_points_of_nodes(model, skin);
  for (const NodeSkinPoint& point : skin_points) samples.push_back({point.slot, point.position});
  add_samples_between(model, skin, skin_points, samples);
  std::erase_if(samples, [&](const LatticeSample& p) {
    return !(model.anatomy.inverse_mass[std::size_t(p.slot)] > 0);
  });
  return samples;
}

/// True when a blade removed the sample's node or cut it from the other one.
bool is_detached(const lattice::Model& model, const lattice::Cuts& cuts, const LatticeSample& sample) {
  const auto removed = [&](int slot) { return cuts.removed[std::size_t(slot)] != 0; };
  if (removed(sample.slot)) return true;
  if (sample.other < 0) return false;
  const Int3 displacement =
      slot_node(model.anatomy.lattice, sample.other) - slot_node(model.anatomy.lattice, sample.slot);
  const bool up = family_of(displacement) >= 0;
  const int family = up ? family_of(displacement) : family_of(-displacement);
  const int lower = up ? sample.slot : sample.other;
  return removed(sample.other) || (cuts.cut[std::size_t(lower)] >> family & 1);
}

/// Adds one sample for every node that carries cut walls: the mean of its wall vertices.
void add_wall_samples(const lattice::Model& model, const lattice::BodySurface& surface,
                      std::vector<LatticeSample>& samples) {
  // wall vertices, ordered by node
  TURGOR_CHECK(surface.slot.size() == surface.rest.size(), "every vertex of the surface has a node");
  std::vector<int> walls;
  for (auto t = std::size_t(surface.skin_triangles); t < surface.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++) walls.push_back(surface.triangles[t][corner]);
  sort_unique(walls);
  const auto slot = [&](int v) { return surface.slot[std::size_t(v)]; };
  std::stable_sort(walls.begin(), walls.end(), [&](int a, int b) { return slot(a) < slot(b); });
  // mean over each node
  for (std::size_t begin = 0, end = 0; begin < walls.size(); begin = end) {
    Vec3d sum;
    for (; end < walls.size() && slot(walls[end]) == slot(walls[begin]); end++)
      sum += Vec3d(surface.rest[std::size_t(walls[end])]);
    if (model.anatomy.inverse_mass[std::size_t(slot(walls[begin]))] > 0)
      samples.push_back({slot(walls[begin]), sum / double(end - begin), true});
  }
}

/// Embeds the samples in cells. One sample between two nodes is enough then.
void embed_in_cells(const lattice::Model& model, const lattice::Cuts& cuts,
                    const lattice::BodySurface& surface, LatticeTouch& touch) {
  std::erase_if(touch.samples, [](const LatticeSample& p) { return p.other >= 0 && p.other < p.slot; });
  touch.points = embed_samples(model, cuts, surface, touch.samples);
  touch.virtual_slots.clear();
  for (const lattice::VirtualNode& node : surface.fragments->virtual_nodes)
    touch.virtual_slots.push_back(node.slot);
}

auto key(const LatticeSample& sample) { return std::tuple(sample.slot, sample.wall, sample.other); }
bool comes_first(const LatticeSample& a, const LatticeSample& b) { return key(a) < key(b); }

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

void update_surface(LatticeTouch& touch, const lattice::Model& model, const lattice::Cuts& cuts,
                    const lattice::BodySurface& surface) {
  // new version; samples without walls and detached ones
  static std::atomic<std::uint64_t> versions = 0;
  touch.version = ++versions;
  const std::vector<LatticeSample> before = touch.samples;
  std::erase_if(touch.samples,
                // wall samples
                [&](const LatticeSample& p) { return p.wall || is_detached(model, cuts, p); });
  // new walls; the other samples are sorted already, except at the first call
  if (!std::is_sorted(touch.samples.begin(), touch.samples.end(), comes_first))
    std::sort(touch.samples.begin(), touch.samples.end(), comes_first);
  const auto skin = std::ptrdiff_t(touch.samples.size());
  add_wall_samples(model, surface, touch.samples);
  std::sort(touch.samples.begin() + skin, touch.samples.end(), comes_first);
  std::inplace_merge(touch.samples.begin(), touch.samples.begin() + skin, touch.samples.end(), comes_first);
  if (touch.in_cells) embed_in_cells(model, cuts, surface, touch);
  // contacts keep their samples, or end
  std::erase_if(touch.contacts, [&](LatticeContact& contact) {
    const LatticeSample& was = before[std::size_t(contact.sample)];
    const auto now = std::lower_bound(touch.samples.begin(), touch.samples.end(), was, comes_first);
    contact.sample = int(now - touch.samples.begin());
    return now == touch.samples.end() || key(*now) != key(was);
  });
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
