#include "turgor/models/lattice/coarse/contact_columns.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/coupled_points.hpp"
#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"

namespace turgor::lattice {

namespace {

constexpr std::size_t kMostPatches = 16;
constexpr double kPatchCells = 4;  // a longer patch is divided, up to the largest number
constexpr int kAffine = 12;        // displacements of a patch
constexpr double kLeastShare =
    1e-6;  // of the largest stiffness: softer displacements of a patch are left out
using AffineMatrix = Eigen::Matrix<double, kAffine, kAffine>;
using AffineRows = Eigen::Matrix<double, 3, kAffine>;

/// A contact that bears.
struct StiffContact {
  std::size_t index = 0;  // into Inputs::contacts
  Vec3d at;               // of its point [cells]
  Mat3d stiffness;        // M [N/m]
};

/// visit(corner, weight) for the nodes and virtual nodes of the point of a contact.
template <class Visit>
void for_each_corner(const Inputs& inputs, std::size_t contact, const Visit& visit) {
  if (inputs.points) {
    const EmbeddedPoint& point = inputs.points->at[contact];
    for (std::size_t c = 0; c < 8; c++)
      if (point.weight[c] != 0) visit(point.corner[c], double(point.weight[c]));
  } else if (const NodeContact& c = inputs.contacts[contact]; c.other >= 0) {
    visit(c.slot, 0.5), visit(c.other, 0.5);
  } else {
    visit(c.slot, 1.0);
  }
}

/// Position of a contact's nodes in the lattice [cells].
Vec3d position_of(const Model& model, const Inputs& inputs, std::size_t contact) {
  const NodeContact& c = inputs.contacts[contact];
  const int first = inputs.points ? inputs.points->at[contact].cell : c.slot;
  return Vec3d(slot_node(model.anatomy.lattice, first));
}

std::vector<StiffContact> stiff_contacts(const Model& model, State& state, const Inputs& inputs) {
  std::vector<StiffContact> stiff;
  const std::vector<ContactForce> forces = contact_forces(model, state, inputs);
  for (std::size_t c = 0; c < forces.size(); c++) {
    const auto [force, along, across] = forces[c];
    if (!(along > 0) && !(across > 0)) continue;
    StiffContact contact{c, position_of(model, inputs, c), {}};
    const Vec3d n(inputs.contacts[c].normal);
    for (int i = 0; i < 3; i++) {
      contact.stiffness.column[i] = n * (n[i] * double(along - across));
      contact.stiffness.column[i][i] += double(across);
    }
    stiff.push_back(contact);
  }
  return stiff;
}

/// Longest axis of the box around contacts, and its bounds.
struct Extent {
  int axis = 0;
  double low = 0, high = 0;

  double length() const { return high - low; }
};
Extent longest_axis(const std::vector<StiffContact>& contacts) {
  Extent longest;
  for (int axis = 0; axis < 3; axis++) {
    const auto [low, high] =
        std::minmax_element(contacts.begin(), contacts.end(),
                            [axis](const auto& a, const auto& b) { return a.at[axis] < b.at[axis]; });
    if (const Extent e{axis, low->at[axis], high->at[axis]}; axis == 0 || e.length() > longest.length())
      longest = e;
  }
  return longest;
}

/// Patches of contacts: the longest one is divided in its middle until all are short, or there are enough.
std::vector<std::vector<StiffContact>> patches_of(std::vector<StiffContact> contacts) {
  std::vector<std::vector<StiffContact>> patches;
  if (contacts.empty()) return patches;
  patches.push_back(std::move(contacts));
  while (patches.size() < kMostPatches) {
    const auto longest = std::max_element(patches.begin(), patches.end(), [](const auto& a, const auto& b) {
      return longest_axis(a).length() < longest_axis(b).length();
    });
    const Extent extent = longest_axis(*longest);
    if (extent.length() <= kPatchCells) break;
    const auto end = std::stable_partition(longest->begin(), longest->end(), [&](const StiffContact& c) {
      return c.at[extent.axis] <= 0.5 * (extent.low + extent.high);
    });
    std::vector<StiffContact> far(end, longest->end());
    longest->erase(end, longest->end());
    patches.push_back(std::move(far));
  }
  return patches;
}

/// M Φ of a contact: Φ has the unit vectors, and their products with the position in the patch.
AffineRows stiff_affine(const StiffContact& contact, Vec3d center, double radius) {
  const Vec3d r = (contact.at - center) / radius;
  const std::array<double, 4> terms{1, r.x, r.y, r.z};
  AffineRows rows;
  for (int term = 0; term < 4; term++)
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        rows(j, 3 * term + i) = contact.stiffness.column[i][j] * terms[std::size_t(term)];
  return rows;
}

/// Adds the columns of a patch.
void add_patch(const std::vector<StiffContact>& patch, const Inputs& inputs, const PointRows& rows,
               PointColumns& columns) {
  Vec3d center;
  for (const StiffContact& contact : patch) center += contact.at / double(patch.size());
  double radius = 1;
  for (const StiffContact& contact : patch) radius = std::max(radius, norm(contact.at - center));
  // Φᵀ M Φ
  AffineMatrix sum = AffineMatrix::Zero();
  for (const StiffContact& contact : patch) {
    const AffineRows stiff = stiff_affine(contact, center, radius);
    const Vec3d r = (contact.at - center) / radius;
    const std::array<double, 4> terms{1, r.x, r.y, r.z};
    for (int term = 0; term < 4; term++)
      sum.block<3, kAffine>(3 * term, 0) += terms[std::size_t(term)] * stiff;
  }
  const Eigen::SelfAdjointEigenSolver<AffineMatrix> modes(sum);
  // a column for each displacement that meets a stiffness
  const double most = modes.eigenvalues()[kAffine - 1];
  for (int m = 0; m < kAffine; m++) {
    if (!(modes.eigenvalues()[m] > kLeastShare * most)) continue;
    const Eigen::Matrix<double, kAffine, 1> mode =
        modes.eigenvectors().col(m) / std::sqrt(modes.eigenvalues()[m]);
    std::vector<CoupledTerm> column;
    for (const StiffContact& contact : patch) {
      const Eigen::Vector3d force = stiff_affine(contact, center, radius) * mode;
      for_each_corner(inputs, contact.index, [&](int corner, double weight) {
        rows.add_node(corner, Vec3d{force.x(), force.y(), force.z()} * weight, column);
      });
    }
    columns.add(std::move(column));
  }
}

}  // namespace

std::vector<ContactForce> contact_forces(const Model& model, State& state, const Inputs& inputs) {
  const CutElementForces cut_elements(model, state);
  if (inputs.points) return PointContacts{inputs.contacts, *inputs.points, cut_elements.view}.forces();
  std::vector<ContactForce> forces;
  for (const NodeContact& c : inputs.contacts)
    forces.push_back(contact_force(c, contact_displacement(c, cut_elements.nodes), was_active(c)));
  return forces;
}

ContactColumns find_contact_columns(const Model& model, State& state, const Inputs& inputs) {
  ContactColumns found;
  if (inputs.contacts.empty()) return found;
  const CoarseSpace& space = *state.workspace.coarse;
  const PointRows rows(model, state, space);
  for (const std::vector<StiffContact>& patch : patches_of(stiff_contacts(model, state, inputs)))
    add_patch(patch, inputs, rows, found.columns);
  if (found.columns.count() == 0) return found;
  found.displacement = displacements_between(space.factor, found.columns, found.columns);
  if (space.coupled)
    found.of_couplings = displacements_between(space.factor, space.coupled->columns, found.columns);
  return found;
}

}  // namespace turgor::lattice
