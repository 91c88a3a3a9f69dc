// Systems of many nodes as a structure of arrays: the buffer that a half row gathers before its nodes move.
#pragma once

#include "turgor/models/lattice/mechanics/element_energies.hpp"

namespace turgor::lattice {

constexpr int kLanes = 256;  // nodes per chunk; longer half rows are split

template <int kCount>
struct Systems {
  alignas(64) Real fx[kCount], fy[kCount], fz[kCount];
  alignas(64) Real xx[kCount], yy[kCount], zz[kCount], xy[kCount], xz[kCount], yz[kCount];

  NodeSystem get(int i) const { return {{fx[i], fy[i], fz[i]}, xx[i], yy[i], zz[i], xy[i], xz[i], yz[i]}; }
  void set(int i, const NodeSystem& s) {
    fx[i] = s.f.x, fy[i] = s.f.y, fz[i] = s.f.z;
    xx[i] = s.xx, yy[i] = s.yy, zz[i] = s.zz, xy[i] = s.xy, xz[i] = s.xz, yz[i] = s.yz;
  }
};
using SystemBuffer = Systems<kLanes>;

}  // namespace turgor::lattice
