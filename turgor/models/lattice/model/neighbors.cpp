#include "turgor/models/lattice/model/neighbors.hpp"

namespace turgor::lattice {

Neighbors neighbors_of(const Model& model, int parity) {
  Neighbors around{};
  for (int n = 0; n < kNeighborCount; n++) {
    const Int3 offset = neighbor_offset(n);
    around.offset[n] = slot_offset(model.lattice, offset, parity);
    around.edge[n] = hadamard(model.lattice.step, Vec3(offset));
    around.rest[n] = model.rest_length[std::size_t(n / 2)];
    around.scale[n] = model.spring_scale[std::size_t(n / 2)];
  }
  return around;
}

}  // namespace turgor::lattice
