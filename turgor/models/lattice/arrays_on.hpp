// Displacements and the like on one side of a bus or the other.
#pragma once

#include "turgor/core/arrays_on.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

template <class Side>
struct VectorsOn {
  typename Side::template Array<Real> x, y, z;

  VectorsOn(Rooms<Side>& rooms, std::size_t slots)
      : x(rooms.template room<Real>(slots)),
        y(rooms.template room<Real>(slots)),
        z(rooms.template room<Real>(slots)) {}
  void upload(const VecField& from) { x.upload(from.x), y.upload(from.y), z.upload(from.z); }
  void download(VecField& to) const { x.download(to.x), y.download(to.y), z.download(to.z); }
};

}  // namespace turgor::lattice
