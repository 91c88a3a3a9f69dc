// Block of one tissue rotated relative to the lattice, for tests and validation. Its expected response is
// that of an aligned block.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/quaternion.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

inline Mat3d rotation_about(Vec3d axis, double degrees) {
  const double half = degrees * std::numbers::pi / 360;
  const Vec3d v = normalized(axis) * std::sin(half);
  return axes_of({std::cos(half), v.x, v.y, v.z});
}

/// Block in its own frame: origin at the center of its top, z up; fixed at its sides and bottom.
struct RotatedBlock {
  double side = 0.096, height = 0.024, spacing = 0.004;  // [m]
  double young = 5e3;                                    // [Pa]
  Mat3d rotation;                                        // from its frame to that of the lattice
  double top = 0;                                        // nodes up to this height belong to it [m]

  /// Distance from the center towards the sides [m].
  static double lateral_distance(Vec3d x) { return std::max(std::abs(x.x), std::abs(x.y)); }
  Vec3d in_block(const Grid& grid, Int3 node) const {
    return transposed(rotation) * point_at(grid, Vec3d(node));
  }
};

/// Nodes of the block with a rim of fixed nodes, two cells wide, and air around it. Node coordinates are
/// multiples of the spacing.
inline BodyNodes rotated_nodes(const RotatedBlock& block) {
  // bounding box
  const double rim = 2.2 * block.spacing, reach = block.side / 2 + rim, tolerance = 1e-6;
  Vec3d low, high;
  for (int corner = 0; corner < 8; corner++) {
    const Vec3d x = block.rotation * Vec3d{corner & 1 ? reach : -reach, corner & 2 ? reach : -reach,
                                           corner & 4 ? block.spacing : -block.height - rim};
    low = min(low, x), high = max(high, x);
  }
  // grid
  BodyNodes nodes;
  nodes.grid.spacing = {block.spacing, block.spacing, block.spacing};
  for (int axis = 0; axis < 3; axis++) {
    const double first = std::floor(low[axis] / block.spacing) - 2;
    nodes.grid.origin[axis] = first * block.spacing;
    nodes.grid.size[axis] = int(std::ceil(high[axis] / block.spacing) - first) + 3;
  }
  // nodes
  const Int3 size = nodes.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Vec3d x = block.in_block(nodes.grid, {i, j, k});
        const bool is_body = x.z < block.top + tolerance && x.z > -block.height - rim &&
                             RotatedBlock::lateral_distance(x) < reach;
        const bool is_held =
            x.z < -block.height + tolerance || RotatedBlock::lateral_distance(x) > block.side / 2 - tolerance;
        nodes.hu.push_back(is_body ? 0 : kAirHu);
        nodes.tissue.push_back(is_body ? Tissue::kMuscle : Tissue::kOutside);
        nodes.young.push_back(is_body ? float(block.young) : 0);
        nodes.fixed.push_back(is_body && is_held);
      }
  return nodes;
}

/// Mean height of its skin nodes, without the rim [m].
inline double mean_height_of_skin(const RotatedBlock& block, const Model& model) {
  double sum = 0;
  int count = 0;
  for (const SkinTriangle& t : model.anatomy.skin.triangles)
    for (int c = 0; c < 3; c++) {
      const Vec3d x = block.in_block(model.anatomy.grid, slot_node(model.anatomy.lattice, t.vertex[c]));
      if (x.z > -block.height / 2 && RotatedBlock::lateral_distance(x) < block.side / 2 - 2 * block.spacing)
        sum += x.z, count++;
    }
  TURGOR_CHECK(count > 0, "a mean is over at least one node");
  return sum / count;
}

/// Model of the block, with its skin at a mean height of 0.
inline Model rotated_model(RotatedBlock block, const Params& params) {
  const auto model = [&] { return assemble(Exec(1), rotated_nodes(block), nullptr, params).value(); };
  block.top = -mean_height_of_skin(block, model());
  return model();
}

}  // namespace turgor::lattice
