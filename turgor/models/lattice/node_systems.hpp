// The systems of many nodes, an array per number: what a half row gathers before its nodes move.
#pragma once

#include "turgor/models/lattice/kernels.hpp"

namespace turgor::lattice {

constexpr int kLanes = 256;  // nodes done at once; longer half rows are done in pieces

struct SystemBuffer {
  alignas(64) Real fx[kLanes], fy[kLanes], fz[kLanes];
  alignas(64) Real xx[kLanes], yy[kLanes], zz[kLanes], xy[kLanes], xz[kLanes], yz[kLanes];

  NodeSystem get(int i) const { return {{fx[i], fy[i], fz[i]}, xx[i], yy[i], zz[i], xy[i], xz[i], yz[i]}; }
  void set(int i, const NodeSystem& s) {
    fx[i] = s.f.x, fy[i] = s.f.y, fz[i] = s.f.z;
    xx[i] = s.xx, yy[i] = s.yy, zz[i] = s.zz, xy[i] = s.xy, xz[i] = s.xz, yz[i] = s.yz;
  }
};

}  // namespace turgor::lattice
