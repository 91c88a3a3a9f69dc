// A block of one tissue that lies across the lattice, for tests and validation: what is asked of it has the
// answer of a block along the lattice.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/geometry/quaternion.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

inline Mat3d turn_about(Vec3d axis, double degrees) {
  const double half = degrees * std::numbers::pi / 360;
  const Vec3d v = normalized(axis) * std::sin(half);
  return axes_of({std::cos(half), v.x, v.y, v.z});
}

/// Its own frame: the origin in the middle of its top, z up; held at its sides and below.
struct TurnedBlock {
  double side = 0.096, height = 0.024, step = 0.004;  // [m]
  double young = 5e3;                                 // [Pa]
  Mat3d turn;                                         // of its frame in the lattice's, a rotation
  double top = 0;                                     // nodes up to here are its own [m]

  /// Distance from the middle towards the sides [m].
  static double aside(Vec3d x) { return std::max(std::abs(x.x), std::abs(x.y)); }
  Vec3d in_block(const Grid& grid, Int3 node) const { return transposed(turn) * point_at(grid, Vec3d(node)); }
};

/// With a rim of held nodes two steps wide, and air around it. The grid's nodes are multiples of a step from
/// the origin.
inline BodyNodes turned_nodes(const TurnedBlock& block) {
  const double rim = 2.2 * block.step, reach = block.side / 2 + rim, hair = 1e-6;
  Vec3d low, high;
  for (int corner = 0; corner < 8; corner++) {
    const Vec3d x = block.turn * Vec3d{corner & 1 ? reach : -reach, corner & 2 ? reach : -reach,
                                       corner & 4 ? block.step : -block.height - rim};
    low = min(low, x), high = max(high, x);
  }
  BodyNodes nodes;
  nodes.grid.spacing = {block.step, block.step, block.step};
  for (int axis = 0; axis < 3; axis++) {
    const double first = std::floor(low[axis] / block.step) - 2;
    nodes.grid.origin[axis] = first * block.step;
    nodes.grid.size[axis] = int(std::ceil(high[axis] / block.step) - first) + 3;
  }
  const Int3 size = nodes.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Vec3d x = block.in_block(nodes.grid, {i, j, k});
        const bool is_body =
            x.z < block.top + hair && x.z > -block.height - rim && TurnedBlock::aside(x) < reach;
        const bool is_held = x.z < -block.height + hair || TurnedBlock::aside(x) > block.side / 2 - hair;
        nodes.hu.push_back(is_body ? 0 : kAirHu);
        nodes.tissue.push_back(is_body ? Tissue::kMuscle : Tissue::kOutside);
        nodes.young.push_back(is_body ? float(block.young) : 0);
        nodes.fixed.push_back(is_body && is_held);
      }
  return nodes;
}

/// How high the nodes of its skin lie in the mean, away from the rim [m].
inline double mean_height_of_skin(const TurnedBlock& block, const Model& model) {
  double sum = 0;
  int count = 0;
  for (const SkinTriangle& t : model.skin.triangles)
    for (int c = 0; c < 3; c++) {
      const Vec3d x = block.in_block(model.grid, slot_node(model.lattice, t.vertex[c]));
      if (x.z > -block.height / 2 && TurnedBlock::aside(x) < block.side / 2 - 2 * block.step)
        sum += x.z, count++;
    }
  return sum / count;
}

/// Its skin lies at height 0 in the mean.
inline Model turned_model(TurnedBlock block, const Params& params) {
  const auto model = [&] { return assemble(Exec(1), turned_nodes(block), nullptr, params).value(); };
  block.top = -mean_height_of_skin(block, model());
  return model();
}

}  // namespace turgor::lattice
