// The local contact of a tool on a lattice, from the contacts of its last step.
#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/contact/local_stiffness.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"

namespace turgor::contact {

namespace {

/// A node gives way as if all others stood still; half a space of them gives way about twice as much
/// [Green's function of a cubic lattice at its surface].
constexpr double kOfItsNode = 0.5;

/// What the contacts of one tool say together.
struct Sum {
  Vec3d normal, place;  // weighted by force, patient frame; of the nearest place while there is no force
  double weight = 0;    // of `place` [N]
  double gap = std::numeric_limits<double>::infinity();  // of the nearest place [m]
  double node_stiffness = 0, stiffest = 0;  // of nodes that bear force, together; of the nearest [N/m]
  int last_node = -1;                       // that was counted among those
  bool is_held = false;
};

/// Of the node of a contact as it gives way itself, without the others [N/m]. Its contacts share it.
double node_stiffness(const LatticeTouch& touch, std::size_t contact) {
  const lattice::NodeContact& node = touch.nodes[contact];
  const auto same = std::equal_range(touch.nodes.begin(), touch.nodes.end(), node,
                                     [](const auto& a, const auto& b) { return a.slot < b.slot; });
  return double(node.stiffness) * double(same.second - same.first) / double(lattice::kContactStiffness);
}

struct Place {
  Vec3d x, normal;     // patient frame; from the tissue at the tool
  double outside = 0;  // of the tool [m]
};

Place place_of(const lattice::Model& model, const lattice::State& state, const LatticeTouch& touch,
               const LatticeContact& contact, const Tool& tool) {
  const LatticePlace& place = touch.places[std::size_t(contact.place)];
  const Vec3d x = place_now(state, place);
  const Pose& pose = touch.poses[std::size_t(contact.tool)].pose;
  const ShapeDistance d = distance(tool.shape, pose, x);
  return {model.grid.origin + model.grid.axes * x, model.grid.axes * -d.normal, d.distance};
}

void add(const Place& place, const LatticeContact& contact, int node, double stiffness, Sum& sum) {
  sum.is_held = sum.is_held || contact.is_held;
  const double force = norm(contact.force);
  if (force > 0) {
    sum.normal += place.normal * force, sum.place += place.x * force;
    sum.weight += force;
    if (node != sum.last_node) sum.node_stiffness += stiffness;
    sum.last_node = node;
  }
  if (place.outside >= sum.gap) return;
  sum.gap = place.outside, sum.stiffest = stiffness;
  if (sum.weight == 0) sum.normal = place.normal;
}

}  // namespace

LocalContact local_contact(const lattice::Model& model, const lattice::State& state,
                           const LatticeTouch& touch, int tool_index, const Tool& tool, const ToolPose& pose,
                           LocalMemory& memory) {
  TURGOR_ASSERT(touch.contacts.size() == touch.nodes.size(), "a local contact is made after a step");
  Sum sum;
  Vec3d force;
  for (std::size_t c = 0; c < touch.contacts.size(); c++) {
    const LatticeContact& contact = touch.contacts[c];
    if (contact.tool != tool_index) continue;
    const Place place = place_of(model, state, touch, contact, tool);
    if (norm(contact.force) > 0 && sum.weight == 0) sum.normal = {};
    add(place, contact, touch.nodes[c].slot, node_stiffness(touch, c), sum);
    force -= pose.pose.axes * contact.force;
  }
  LocalContact made{.is_near = sum.gap < std::numeric_limits<double>::infinity(),
                    .is_held = sum.is_held,
                    .origin = pose.pose.position,
                    .force = force,
                    .friction = tool.friction};
  const Vec3 h = model.lattice.step;
  made.reach = 2 * double(std::max({h.x, h.y, h.z}));
  if (norm(sum.normal) > 0) made.normal = normalized(sum.normal);
  if (sum.weight > 0) made.arm = sum.place / sum.weight - made.origin;
  if (sum.weight == 0) made.gap = made.is_near ? std::max(0.0, sum.gap) : 0;
  const double guess = kOfItsNode * (sum.weight > 0 ? sum.node_stiffness : sum.stiffest);
  const double most = sum.weight > 0 ? sum.node_stiffness : std::numeric_limits<double>::infinity();
  measure_stiffness(guess, most, memory, made);
  return made;
}

}  // namespace turgor::contact
