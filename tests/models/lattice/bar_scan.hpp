// Bars of water in the CT of air, and lattices of them.
#pragma once

#include <cmath>
#include <functional>

#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

inline const Exec kExec(2);
constexpr double kYoung = 2e4, kPoisson = 0.45, kVoxel = 1e-3;  // [Pa] [1] [m]

/// A bar of side × side × length in a CT: its middle, and its axes (width, height, length).
struct Bar {
  double side, length;  // [m]
  Vec3d middle;
  Mat3d axes;

  Vec3d local(Vec3d x) const {
    const Vec3d d = x - middle;
    return {dot(d, axes.column[0]), dot(d, axes.column[1]), dot(d, axes.column[2])};
  }
  double volume() const { return side * side * length; }
};

/// Axes with the last one along `direction`, turned about it.
inline Mat3d axes_along(Vec3d direction, double turn) {
  const Vec3d c = normalized(direction),
              a = normalized(cross(c, std::abs(c.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
              b = cross(c, a);
  Mat3d axes;
  axes.column[0] = a * std::cos(turn) + b * std::sin(turn);
  axes.column[1] = cross(c, axes.column[0]);
  axes.column[2] = c;
  return axes;
}

/// CT of a bar of water in air whose middle is `offset` steps from a node.
struct Scan {
  CtVolume ct;
  Bar bar;
};
inline Scan scan_bar(int side, int length, int block, Vec3d direction, double turn, Vec3d offset) {
  Scan scan;
  scan.bar = {
      .side = side * kVoxel, .length = length * kVoxel, .middle = {}, .axes = axes_along(direction, turn)};
  Int3 nodes;
  for (int axis = 0; axis < 3; axis++) {
    double reach = 0;
    for (int c = 0; c < 3; c++)
      reach += std::abs(scan.bar.axes.column[c][axis]) * 0.5 * (c == 2 ? length : side);
    nodes[axis] = int(std::ceil(reach / block)) + 3;
    scan.ct.grid.size[axis] = 2 * nodes[axis] * block;
    scan.bar.middle[axis] = (nodes[axis] + offset[axis]) * block * kVoxel;
  }
  scan.ct.grid.spacing = {kVoxel, kVoxel, kVoxel};
  const Int3 size = scan.ct.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Vec3d at = scan.bar.local(Vec3d{i + 0.5, j + 0.5, k + 0.5} * kVoxel);
        const bool in = std::abs(at.x) <= scan.bar.side / 2 && std::abs(at.y) <= scan.bar.side / 2 &&
                        std::abs(at.z) <= scan.bar.length / 2;
        scan.ct.samples.push_back(in ? std::int16_t(0) : kAirHu);
      }
  return scan;
}

/// Lattice of a bar. Nodes are fixed where `is_fixed` is true of their position in the bar's axes [m].
inline Model make_bar_model(const Scan& scan, int block, bool partial,
                            const std::function<bool(Vec3d)>& is_fixed) {
  Params params;
  params.block = {block, block, block};
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.poisson = kPoisson;
  params.tissue.partial_cells = partial;
  params.tissue.fat = params.tissue.muscle = kYoung;
  params.solver = {.sweeps = 20, .damping = 20};
  BodyNodes nodes = classify(kExec, scan.ct, nullptr, params).value();
  const Int3 size = nodes.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (is_fixed(scan.bar.local(hadamard(Vec3d(Int3{i, j, k}), nodes.grid.spacing))))
          nodes.fixed[sample_index(nodes.grid, i, j, k)] = 1;
  return assemble(kExec, nodes, nullptr, params).value();
}

}  // namespace turgor::lattice
