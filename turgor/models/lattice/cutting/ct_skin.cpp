#include "turgor/models/lattice/cutting/ct_skin.hpp"

#include <cmath>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/cutting/skin_near.hpp"

namespace turgor::lattice {

namespace {

/// Level of air at a point of the CT, trilinear in the nodes of its cell [HU]; air outside the lattice.
double level_at(const Model& model, const Cuts& cuts, Vec3d rest) {
  const Lattice& l = model.anatomy.lattice;
  Int3 cell;
  Vec3d in_cell;
  for (int axis = 0; axis < 3; axis++) {
    const double at = rest[axis] / double(l.spacing[axis]) - (axis == 2 ? l.first : 0);
    cell[axis] = int(std::floor(at)), in_cell[axis] = at - cell[axis];
  }
  if (!contains(l, cell) || !contains(l, cell + Int3{1, 1, 1})) return double(kAirHu);
  const auto weight = trilinear(in_cell);
  double level = 0;
  for (int c = 0; c < kCellCorners; c++)
    level += weight[std::size_t(c)] * double(node_level(model, cuts, node_slot(l, cell + cell_corner(c))));
  return level;
}

/// Displacement of the skin node nearest to a point [m].
Vec3d displacement_near(const Model& model, const Motion& motion, Vec3d point) {
  double nearest = std::numeric_limits<double>::max();
  Vec3d displacement;
  for (const SkinTriangle& t : model.anatomy.skin.triangles)
    for (int corner = 0; corner < 3; corner++) {
      const Vec3d away =
          Vec3d(position(model, motion, slot_node(model.anatomy.lattice, t.vertex[corner]))) - point;
      if (dot(away, away) < nearest)
        nearest = dot(away, away), displacement = Vec3d(motion.u[std::size_t(t.vertex[corner])]);
    }
  return displacement;
}

/// Center of a patch, lattice frame [m].
Vec3d patch_center(const Lattice& l, const SkinPatch& patch) {
  return Vec3d(rest_position(l, slot_node(l, patch.cell))) +
         hadamard(Vec3d(patch.point) + Vec3d{1, 1, 1}, Vec3d(l.spacing)) * 0.5;
}

/// Height of the skin of partial cells above a point of the CT: a mean of the planes of the patches near the
/// point, weighted by area and 1 − d²/r², where d is the distance along the skin [m].
double patch_height(const Model& model, Vec3d rest, Vec3d inward) {
  constexpr double kReach = 1.5, kFarthest = 2.5;  // along the skin and across it [spacings]
  const Lattice& l = model.anatomy.lattice;
  const double spacing = largest_spacing(l), reach = kReach * spacing;
  double height = 0, sum = 0;
  for (const SkinPatch& patch : model.anatomy.skin.patches) {
    const Vec3d away = patch_center(l, patch) - rest, normal = cross(Vec3d(patch.along), Vec3d(patch.across));
    const double along_inward = dot(away, inward), facing = -dot(normal, inward),
                 beside = dot(away, away) - along_inward * along_inward;
    if (std::abs(along_inward) > kFarthest * spacing || beside >= reach * reach || !(facing > 0)) continue;
    const double weight = double(patch.area) * (1 - beside / (reach * reach));
    height += weight * dot(away, normal), sum += weight * facing;
  }
  return sum > 0 ? height / sum : 0;
}

/// Mean direction into the body of the patches around a point; zero without any.
Vec3d inward_near(const Model& model, Vec3d point) {
  constexpr double kReach = 2.5;  // [spacings]
  const Lattice& l = model.anatomy.lattice;
  const double reach = kReach * largest_spacing(l);
  Vec3d sum;
  for (const SkinPatch& patch : model.anatomy.skin.patches) {
    const Vec3d away = patch_center(l, patch) - point;
    if (const double near = 1 - dot(away, away) / (reach * reach); near > 0)
      sum -= cross(Vec3d(patch.along), Vec3d(patch.across)) * (double(patch.area) * near);
  }
  return norm(sum) > 0 ? normalized(sum) : Vec3d{};
}

}  // namespace

std::vector<Vec3d> lifted_to_patches(const Model& model, const std::vector<Vec3d>& points) {
  std::vector<Vec3d> lifted = points;
  for (Vec3d& point : lifted) {
    const Vec3d inward = inward_near(model, point);
    if (inward == Vec3d{}) continue;
    const double height = patch_height(model, point, inward);
    if (height > 0 && height < smallest_spacing(model.anatomy.lattice)) point -= inward * height;
  }
  return lifted;
}

std::vector<double> patch_heights(const Model& model, const std::vector<Vec3d>& points,
                                  const std::vector<Vec3d>& inward) {
  TURGOR_ASSERT(points.size() == inward.size(), "every point has a direction into the body");
  std::vector<double> heights;
  for (std::size_t n = 0; n < points.size(); n++)
    heights.push_back(patch_height(model, points[n], inward[n]));
  return heights;
}

std::vector<double> ct_skin_heights(const Model& model, const State& state, const std::vector<Vec3d>& points,
                                    const std::vector<Vec3d>& inward) {
  TURGOR_ASSERT(points.size() == inward.size(), "every point has a direction into the body");
  constexpr double kBelow = -1, kAbove = 2, kStep = 0.1;  // range and step of the search [spacings]
  const double spacing = largest_spacing(model.anatomy.lattice);
  std::vector<double> heights;
  for (std::size_t n = 0; n < points.size(); n++) {
    const Vec3d rest = points[n] - displacement_near(model, state.motion, points[n]);
    if (!model.anatomy.skin.patches.empty()) {
      heights.push_back(patch_height(model, rest, inward[n]));
      continue;
    }
    const auto level = [&](double height) {
      return level_at(model, state.cuts, rest - inward[n] * (height * spacing));
    };
    // first crossing outward from tissue
    double found = 0, before = level(kBelow);
    for (double height = kBelow + kStep; before > 0 && height < kAbove; height += kStep) {
      const double now = level(height);
      if (now <= 0) found = height - kStep * now / (now - before);
      before = now;
    }
    heights.push_back(found * spacing);
  }
  return heights;
}

}  // namespace turgor::lattice
