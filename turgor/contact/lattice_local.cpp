// Local contact of a tool on a lattice, from its contacts in the last step.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "turgor/contact/local_stiffness.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"

namespace turgor::contact {

namespace {

/// Stiffness of a half space relative to that of its surface node with all other nodes fixed [Green's
/// function of a cubic lattice at its surface].
constexpr double kHalfSpaceFactor = 0.5;

/// Sum over the contacts of one tool.
struct ContactSum {
  Vec3d normal, point;  // weighted by force, patient frame; of the nearest sample while there is no force
  double weight = 0;    // of `point` [N]
  double gap = std::numeric_limits<double>::infinity();  // of the nearest sample [m]
  double node_stiffness = 0, stiffest = 0;  // sum over nodes that bear force; of the nearest node [N/m]
  std::vector<int> nodes;                   // included in that sum
  bool is_held = false;
};

/// Stiffness of a contact's node with all other nodes fixed [N/m]. Contacts of one node share it.
double node_stiffness(const LatticeTouch& touch, std::size_t contact) {
  const lattice::NodeContact& node = touch.nodes[contact];
  if (!touch.points.empty()) {
    const lattice::ContactPoints& points = touch.contact_points;
    return double(node.stiffness) * double(points.concentration[contact]) *
           double(share_sum(points, terms_of(points, points.leader[contact], 1))) /
           double(lattice::kPointContactStiffness);
  }
  TURGOR_CHECK(is_ascending(touch.nodes, &lattice::NodeContact::slot), "contacts ascend by node");
  const auto same = std::equal_range(touch.nodes.begin(), touch.nodes.end(), node,
                                     [](const auto& a, const auto& b) { return a.slot < b.slot; });
  return double(node.stiffness) * double(same.second - same.first) / double(lattice::kContactStiffness);
}

struct ContactPoint {
  Vec3d x, normal;     // patient frame; from the tissue at the tool
  double outside = 0;  // of the tool [m]
};

ContactPoint contact_point(const lattice::Model& model, const lattice::Motion& motion,
                           const LatticeTouch& touch, const LatticeContact& contact, const Tool& tool) {
  TURGOR_CHECK(is_index(contact.sample, touch.samples.size()), "a contact refers to a sample of the surface");
  TURGOR_CHECK(is_index(contact.tool, touch.poses.size()), "a contact refers to a tool of the touch");
  const Vec3d x = sample_position(touch, motion, contact.sample);
  const Pose& pose = touch.poses[std::size_t(contact.tool)].pose;
  const ShapeDistance d = distance(tool.shape, pose, x);
  return {model.anatomy.grid.origin + model.anatomy.grid.axes * x, model.anatomy.grid.axes * -d.normal,
          d.distance};
}

void add(const ContactPoint& point, const LatticeContact& contact, int node, double stiffness,
         ContactSum& sum) {
  sum.is_held = sum.is_held || contact.is_held;
  const double force = norm(contact.force);
  if (force > 0) {
    sum.normal += point.normal * force, sum.point += point.x * force;
    sum.weight += force;
    const bool is_new = std::find(sum.nodes.begin(), sum.nodes.end(), node) == sum.nodes.end();
    if (is_new) sum.node_stiffness += stiffness, sum.nodes.push_back(node);
  }
  if (point.outside >= sum.gap) return;
  sum.gap = point.outside, sum.stiffest = stiffness;
  if (sum.weight == 0) sum.normal = point.normal;
}

}  // namespace

LocalContact local_contact(const lattice::Model& model, const lattice::Motion& motion,
                           const LatticeTouch& touch, int tool_index, const Tool& tool, const ToolPose& pose,
                           LocalContactHistory& memory) {
  TURGOR_ASSERT(touch.contacts.size() == touch.nodes.size(), "a local contact requires a step");
  // sum over the contacts of the tool
  ContactSum sum;
  Vec3d force;
  for (std::size_t c = 0; c < touch.contacts.size(); c++) {
    const LatticeContact& contact = touch.contacts[c];
    if (contact.tool != tool_index) continue;
    const ContactPoint point = contact_point(model, motion, touch, contact, tool);
    if (norm(contact.force) > 0 && sum.weight == 0) sum.normal = {};
    add(point, contact, touch.nodes[c].slot, node_stiffness(touch, c), sum);
    force -= pose.pose.axes * contact.force;
  }
  // tangent plane at the mean contact point
  LocalContact contact{.is_near = sum.gap < std::numeric_limits<double>::infinity(),
                       .is_held = sum.is_held,
                       .origin = pose.pose.position,
                       .force = force,
                       .friction = tool.friction};
  const Vec3 h = model.anatomy.lattice.spacing;
  contact.reach = 2 * double(std::max({h.x, h.y, h.z}));
  if (norm(sum.normal) > 0) contact.normal = normalized(sum.normal);
  if (sum.weight > 0) contact.arm = sum.point / sum.weight - contact.origin;
  if (sum.weight == 0) contact.gap = contact.is_near ? std::max(0.0, sum.gap) : 0;
  // stiffness: estimate and upper bound
  const double guess = kHalfSpaceFactor * (sum.weight > 0 ? sum.node_stiffness : sum.stiffest);
  const double most = sum.weight > 0 ? sum.node_stiffness : std::numeric_limits<double>::infinity();
  measure_stiffness(guess, most, memory, contact);
  return contact;
}

}  // namespace turgor::contact
