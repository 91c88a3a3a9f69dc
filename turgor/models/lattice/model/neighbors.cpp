#include "turgor/models/lattice/model/neighbors.hpp"

namespace turgor::lattice {

Neighbors neighbors_of(const Model& model, int parity) {
  Neighbors stencil{};
  for (int n = 0; n < kNeighborCount; n++) {
    const Int3 offset = neighbor_offset(n);
    stencil.offset[n] = slot_offset(model.anatomy.lattice, offset, parity);
    stencil.edge[n] = hadamard(model.anatomy.lattice.spacing, Vec3(offset));
    stencil.rest[n] = model.springs.rest_length[std::size_t(n / 2)];
    stencil.scale[n] = model.springs.scale[std::size_t(n / 2)];
  }
  return stencil;
}

}  // namespace turgor::lattice
