#include "turgor/contact/lattice_touch.hpp"

#include <algorithm>
#include <atomic>
#include <tuple>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"

namespace turgor::contact {

namespace {

/// Does tissue end at this node: beside air, or because the scan does?
bool is_outermost(const lattice::Model& model, Int3 node) {
  for (int n = 0; n < lattice::kNeighborCount; n++) {
    const Int3 other = node + lattice::neighbor_offset(n);
    if (!contains(model.lattice, other)) return true;
    if (!is_body(model.tissue[std::size_t(node_slot(model.lattice, other))])) return true;
  }
  return false;
}

/// The outermost nodes by slot, and the point of the drawn skin that is nearest to each.
struct Foot {
  int slot = 0;
  Int3 node;
  Vec3d place;  // lattice frame [m]
};
std::vector<Foot> feet_of(const lattice::Model& model, const TriangleTree& skin) {
  std::vector<Foot> feet;
  const Int3 size = model.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Int3 node{i, j, k};
        const int slot = node_slot(model.lattice, node);
        if (!is_body(model.tissue[std::size_t(slot)]) || !is_outermost(model, node)) continue;
        const Vec3d rest(rest_position(model.lattice, node));
        feet.push_back({slot, node, nearest_point(skin, rest).place});
      }
  std::sort(feet.begin(), feet.end(), [](const Foot& a, const Foot& b) { return a.slot < b.slot; });
  return feet;
}

/// Halfway between the feet of neighbours, where a tool would sink in between them. Neighbours above each
/// other stand on the same skin.
void add_places_between(const lattice::Model& model, const TriangleTree& skin, const std::vector<Foot>& feet,
                        std::vector<LatticePlace>& places) {
  const Vec3 h = model.lattice.step;
  const double nearest = 0.5 * double(std::min({h.x, h.y, h.z}));
  for (const Foot& foot : feet)
    for (const Int3 family : kFamilies) {
      const Int3 node = foot.node + family;
      if (!contains(model.lattice, node)) continue;
      const int slot = node_slot(model.lattice, node);
      const auto other = std::lower_bound(feet.begin(), feet.end(), slot,
                                          [](const Foot& f, int sought) { return f.slot < sought; });
      if (other == feet.end() || other->slot != slot) continue;
      if (!(norm(other->place - foot.place) > nearest)) continue;
      const Vec3d place = nearest_point(skin, (foot.place + other->place) * 0.5).place;
      places.push_back({foot.slot, place, false, slot});
      places.push_back({slot, place, false, foot.slot});
    }
}

/// At rest, without cuts: one for every node that has skin, and one between any two of them.
std::vector<LatticePlace> skin_places(const lattice::Model& model, const lattice::BodySurface& surface) {
  std::vector<LatticePlace> places;
  if (surface.skin_triangles == 0) return places;
  const auto triangles = surface.triangles.begin();
  const TriangleTree skin = build_triangle_tree({surface.rest.begin(), surface.rest.end()},
                                                {triangles, triangles + surface.skin_triangles});
  const std::vector<Foot> feet = feet_of(model, skin);
  for (const Foot& foot : feet) places.push_back({foot.slot, foot.place});
  add_places_between(model, skin, feet, places);
  std::erase_if(places,
                [&](const LatticePlace& p) { return !(model.inverse_mass[std::size_t(p.slot)] > 0); });
  return places;
}

/// Has it lost its node, or its neighbour to a blade?
bool is_gone(const lattice::Model& model, const lattice::State& state, const LatticePlace& place) {
  const auto removed = [&](int slot) { return state.removed[std::size_t(slot)] != 0; };
  if (removed(place.slot)) return true;
  if (place.other < 0) return false;
  const Int3 way = slot_node(model.lattice, place.other) - slot_node(model.lattice, place.slot);
  const bool up = family_of(way) >= 0;
  const int family = up ? family_of(way) : family_of(-way);
  const int lower = up ? place.slot : place.other;
  return removed(place.other) || (state.cut[std::size_t(lower)] >> family & 1);
}

/// One for every node that carries walls of cuts: the mean of what it carries of them.
void add_wall_places(const lattice::Model& model, const lattice::BodySurface& surface,
                     std::vector<LatticePlace>& places) {
  std::vector<int> walls;
  for (auto t = std::size_t(surface.skin_triangles); t < surface.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++) walls.push_back(surface.triangles[t][corner]);
  sort_unique(walls);
  const auto slot = [&](int v) { return surface.slot[std::size_t(v)]; };
  std::stable_sort(walls.begin(), walls.end(), [&](int a, int b) { return slot(a) < slot(b); });
  for (std::size_t begin = 0, end = 0; begin < walls.size(); begin = end) {
    Vec3d sum;
    for (; end < walls.size() && slot(walls[end]) == slot(walls[begin]); end++)
      sum += Vec3d(surface.rest[std::size_t(walls[end])]);
    if (model.inverse_mass[std::size_t(slot(walls[begin]))] > 0)
      places.push_back({slot(walls[begin]), sum / double(end - begin), true});
  }
}

auto key(const LatticePlace& place) { return std::tuple(place.slot, place.wall, place.other); }
bool comes_first(const LatticePlace& a, const LatticePlace& b) { return key(a) < key(b); }

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

/// Of contacts beyond a tool [m].
double contact_reach(const lattice::Model& model) {
  const Vec3 h = model.lattice.step;
  return std::max({h.x, h.y, h.z});
}
/// What each tool may come to on its way from its last pose to that one [lattice frame].
std::vector<lattice::Ball> balls_around(const lattice::Model& model, const LatticeTouch& touch,
                                        std::span<const Tool> tools, std::span<const ToolPose> to) {
  TURGOR_ASSERT(tools.size() == to.size() && tools.size() == touch.poses.size(), "one pose a tool");
  std::vector<lattice::Ball> balls;
  for (std::size_t t = 0; t < tools.size(); t++) {
    const double way = norm(to[t].pose.position - touch.poses[t].pose.position);
    balls.push_back({to[t].pose.position, bounding_radius(tools[t].shape) + contact_reach(model) + way});
  }
  return balls;
}

std::vector<int> with_touched(const LatticeTouch& touch, std::vector<int> near) {
  for (const LatticeContact& contact : touch.contacts) near.push_back(contact.place);
  sort_unique(near);
  return near;
}

bool comes_before(const LatticeContact& a, const LatticeContact& b) {
  return a.place != b.place ? a.place < b.place : a.tool < b.tool;
}

/// What one tool does in a step.
struct ToolStep {
  const Tool& tool;
  const ToolPose &from, &to;
  lattice::Ball around;  // no place beyond it can come into contact
};

/// The places near the tools as contacts for a step: on planes where the tool will be, as seen from where a
/// place's own velocity leads; sticking means to go along with the tool.
struct FindContacts {
  const lattice::Model& model;
  const lattice::State& state;
  LatticeTouch& touch;
  double reach = 0;  // of contacts beyond a tool [m]
  double dt = 0;

  void add(int p, int t, const ToolStep& s, const LatticeContact& before) const {
    const LatticePlace& place = touch.places[std::size_t(p)];
    const Vec3d x = place_now(state, place), local = to_tool(s.from.pose, x);
    LatticeContact contact{p, t, before.is_held, before.anchor, before.force};
    if (!s.to.hold) contact.is_held = false;
    if (s.to.hold && !s.from.hold && norm(before.force) > 0) contact.is_held = true, contact.anchor = local;
    const Vec3d carried = to_world(s.to.pose, contact.is_held ? contact.anchor : local);
    const Vec3d led = x + mean_of(state.v, place) * dt;
    const ShapeDistance d = distance(s.tool.shape, s.to.pose, led);
    if (d.distance > reach && !contact.is_held) return;
    lattice::NodeContact node{.slot = place.slot,
                              .other = place.other,
                              .normal = Vec3(d.normal),
                              .friction = Real(s.tool.friction),
                              .is_held = contact.is_held,
                              .force = Vec3(s.to.pose.axes * contact.force)};
    const Vec3d foot = led - d.normal * d.distance;
    const Vec3d target = contact.is_held ? carried : carried + d.normal * dot(d.normal, foot - carried);
    node.target = Vec3(target - place.rest);
    touch.nodes.push_back(node);
    touch.contacts.push_back(contact);
  }

  void operator()(std::span<const ToolStep> steps, std::span<const int> near) const {
    const std::vector<LatticeContact> before = std::move(touch.contacts);
    auto known = before.begin();
    touch.contacts.clear(), touch.nodes.clear();
    for (const int p : near) {
      const Vec3d x = place_now(state, touch.places[std::size_t(p)]);
      for (std::size_t t = 0; t < steps.size(); t++) {
        LatticeContact contact{.place = p, .tool = int(t)};
        while (known != before.end() && comes_before(*known, contact)) ++known;
        const bool was = known != before.end() && !comes_before(contact, *known);
        if (was || contains(steps[t].around, x)) add(p, int(t), steps[t], was ? *known : contact);
      }
    }
  }
};

}  // namespace

LatticeTouch make_lattice_touch(const lattice::Model& model, const lattice::State& state,
                                const lattice::BodySurface& surface, std::span<const ToolPose> poses) {
  LatticeTouch touch;
  touch.places = skin_places(model, surface);
  for (const ToolPose& pose : poses) touch.poses.push_back(in_lattice(model.grid, pose));
  take_surface(touch, model, state, surface);
  return touch;
}

void take_surface(LatticeTouch& touch, const lattice::Model& model, const lattice::State& state,
                  const lattice::BodySurface& surface) {
  static std::atomic<std::uint64_t> versions = 0;
  touch.version = ++versions;
  const std::vector<LatticePlace> before = touch.places;
  std::erase_if(touch.places, [&](const LatticePlace& p) { return p.wall || is_gone(model, state, p); });
  add_wall_places(model, surface, touch.places);
  std::sort(touch.places.begin(), touch.places.end(), comes_first);
  std::erase_if(touch.contacts, [&](LatticeContact& contact) {
    const LatticePlace& was = before[std::size_t(contact.place)];
    const auto now = std::lower_bound(touch.places.begin(), touch.places.end(), was, comes_first);
    contact.place = int(now - touch.places.begin());
    return now == touch.places.end() || key(*now) != key(was);
  });
}

void teleport_tool(LatticeTouch& touch, const lattice::Model& model, int tool, const ToolPose& pose) {
  touch.poses[std::size_t(tool)] = in_lattice(model.grid, pose);
  std::erase_if(touch.contacts, [tool](const LatticeContact& contact) { return contact.tool == tool; });
}

std::vector<int> places_near(const lattice::Model& model, const lattice::DeviceState& state,
                             const LatticeTouch& touch, std::span<const Tool> tools,
                             std::span<const ToolPose> poses) {
  const std::vector<lattice::Ball> balls = balls_around(model, touch, tools, in_lattice(model.grid, poses));
  return with_touched(touch, state.places_in(touch.places, touch.version, balls));
}
std::vector<int> places_near(const lattice::Model& model, const lattice::State& state,
                             const LatticeTouch& touch, std::span<const Tool> tools,
                             std::span<const ToolPose> poses) {
  const std::vector<lattice::Ball> balls = balls_around(model, touch, tools, in_lattice(model.grid, poses));
  return with_touched(touch, places_in(touch.places, state, balls));
}

std::vector<int> nodes_of(const LatticeTouch& touch, std::span<const int> places) {
  std::vector<int> nodes;
  for (const int p : places) {
    const LatticePlace& place = touch.places[std::size_t(p)];
    nodes.push_back(place.slot);
    if (place.other >= 0) nodes.push_back(place.other);
  }
  return nodes;
}

std::span<lattice::NodeContact> find_contacts(const lattice::Model& model, const lattice::State& state,
                                              LatticeTouch& touch, std::span<const Tool> tools,
                                              std::span<const ToolPose> poses, double dt,
                                              std::span<const int> near) {
  std::vector<ToolPose> to = in_lattice(model.grid, poses);
  const std::vector<lattice::Ball> balls = balls_around(model, touch, tools, to);
  std::vector<ToolStep> steps;
  for (std::size_t t = 0; t < tools.size(); t++) steps.push_back({tools[t], touch.poses[t], to[t], balls[t]});
  FindContacts{model, state, touch, contact_reach(model), dt}(steps, near);
  touch.poses = std::move(to);
  return touch.nodes;
}

/// Of the tools in the patient frame, and the contacts' own for the next step.
void read_forces(const lattice::Model& model, const lattice::State& state, LatticeTouch& touch,
                 std::span<const Tool> tools, std::span<ToolForce> forces) {
  TURGOR_ASSERT(tools.size() == forces.size(), "one force a tool");
  for (ToolForce& force : forces) force = {};
  for (std::size_t c = 0; c < touch.contacts.size(); c++) {
    LatticeContact& contact = touch.contacts[c];
    const lattice::NodeContact& node = touch.nodes[c];
    const Pose& pose = touch.poses[std::size_t(contact.tool)].pose;
    const LatticePlace& place = touch.places[std::size_t(contact.place)];
    const Vec3d x = place_now(state, place), force(node.force);
    for (int axis = 0; axis < 3; axis++) contact.force[axis] = dot(pose.axes.column[axis], force);
    ToolForce& haptic = forces[std::size_t(contact.tool)];
    const double outside = distance(tools[std::size_t(contact.tool)].shape, pose, x).distance;
    if (!contact.is_held) haptic.largest_penetration = std::max(haptic.largest_penetration, -outside);
    if (!(norm(force) > 0)) continue;
    haptic.contacts++;
    const double pressing = dot(Vec3d(node.normal), force);
    const double rubbing = norm(force - Vec3d(node.normal) * pressing);
    if (!contact.is_held && rubbing > double(node.friction) * pressing * (1 - 1e-4)) haptic.sliding++;
    const Vec3d on_tool = model.grid.axes * -force, arm = model.grid.axes * (x - pose.position);
    haptic.force += on_tool;
    haptic.torque += cross(arm, on_tool);
  }
}

lattice::StepReport step(const Exec& exec, const lattice::Model& model, lattice::State& state,
                         LatticeTouch& touch, std::span<const Tool> tools, std::span<const ToolPose> poses,
                         lattice::Inputs inputs, double dt, std::span<ToolForce> forces) {
  const std::vector<int> near = places_near(model, state, touch, tools, poses);
  inputs.contacts = find_contacts(model, state, touch, tools, poses, dt, near);
  const lattice::StepReport report = lattice::step(exec, model, state, inputs, dt);
  read_forces(model, state, touch, tools, forces);
  return report;
}

}  // namespace turgor::contact
