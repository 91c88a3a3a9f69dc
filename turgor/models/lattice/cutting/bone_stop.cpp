#include "turgor/models/lattice/cutting/bone_stop.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

/// Distance along `direction` at which a line enters a box with half edges `half` around `center`; `most` if
/// it does not before. A line that starts inside enters at 0.
double entry_depth(Vec3d origin, Vec3d direction, Vec3d center, Vec3d half, double most) {
  double from = 0, to = most;
  for (int axis = 0; axis < 3; axis++) {
    const double low = center[axis] - half[axis] - origin[axis], high = low + 2 * half[axis];
    if (std::abs(direction[axis]) < 1e-12) {
      if (low > 0 || high < 0) return most;
      continue;
    }
    const double a = low / direction[axis], b = high / direction[axis];
    from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
  }
  return from <= to ? from : most;
}

/// Current positions of the owned bone nodes in a box.
std::vector<Vec3d> bone_nodes_in(const Model& model, const Motion& motion, const Box& box) {
  std::vector<Vec3d> found;
  const Anatomy& anatomy = model.anatomy;
  for (int k = anatomy.owned.begin; k < anatomy.owned.end; k++)
    for (int j = 0; j < anatomy.lattice.size.y; j++)
      for (int i = 0; i < anatomy.lattice.size.x; i++) {
        if (anatomy.tissue[std::size_t(node_slot(anatomy.lattice, i, j, k))] != Tissue::kBone) continue;
        const Vec3d at(position(model, motion, Int3{i, j, k}));
        if (squared_distance(box, at) == 0) found.push_back(at);
      }
  return found;
}

}  // namespace

std::vector<double> depths_above_bone(const Model& model, const Motion& motion, const BladePath& path,
                                      double tilt, const HaloExchange* halo) {
  const std::size_t count = path.points.size();
  TURGOR_CHECK(path.inward.size() == count, "every point of a path has a direction");
  const Vec3d half = Vec3d(model.anatomy.lattice.spacing) * 0.5;

  // rulings of the blade, and bone near them
  std::vector<Vec3d> down(count), ends = path.points;
  for (std::size_t n = 0; n < count; n++) {
    down[n] = path.inward[n] + across_at(path, n) * std::tan(tilt);  // displacement per unit of depth
    ends.push_back(path.points[n] + down[n] * path.depth);
  }
  Box box = box_around(ends);
  box.low -= half, box.high += half;
  const std::vector<Vec3d> bone = bone_nodes_in(model, motion, box);

  // shallowest bone of each ruling, over all processes
  std::vector<double> depths(count, path.depth);
  for (std::size_t n = 0; n < count; n++)
    for (const Vec3d node : bone)
      depths[n] = std::min(depths[n], entry_depth(path.points[n], down[n], node, half, path.depth));
  if (!halo) return depths;
  std::vector<double> all = depths;
  halo->join_numbers(all);
  for (std::size_t n = 0; n < all.size(); n++) depths[n % count] = std::min(depths[n % count], all[n]);
  return depths;
}

}  // namespace turgor::lattice
