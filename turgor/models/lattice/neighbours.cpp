#include "turgor/models/lattice/neighbours.hpp"

namespace turgor::lattice {

Neighbours neighbours_of(const Model& model, int parity) {
  Neighbours n{};
  for (int e = 0; e < 14; e++) {
    const auto f = std::size_t(e / 2);
    const Int3 offset = e % 2 == 0 ? kFamilies[f] : -kFamilies[f];
    n.offset[e] = slot_offset(model.lattice, offset, parity);
    n.edge[e] = hadamard(model.lattice.step, Vec3(offset));
    n.rest[e] = model.rest_length[f];
    n.scale[e] = model.spring_scale[f];
  }
  return n;
}

/// Offsets between nodes that are at most one apart, seen from a node at the origin with i of the given parity. Corners of a
/// tetrahedron are, so edges between two other corners start at such a node too.
TetsAround tets_of(const Lattice& l, int parity) {
  TetsAround around{};
  int t = 0;
  for (const auto& tet : kKuhnTets)
    for (std::size_t at = 0; at < 4; at++, t++) {
      // even permutations that bring corner `at` to the front
      constexpr int kOrder[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
      for (std::size_t c = 0; c < 3; c++) {
        const Int3 offset = tet[std::size_t(kOrder[at][c + 1])] - tet[at];
        around.tet[t].offset[c] = slot_offset(l, offset, parity);
        around.tet[t].edge[c] = hadamard(l.step, Vec3(offset));
      }
      int e = 0;
      for (std::size_t p = 0; p < 4; p++)
        for (std::size_t q = p + 1; q < 4; q++, e++) {
          const bool forward = family_of(tet[q] - tet[p]) >= 0;
          const Int3 lower = tet[forward ? p : q], upper = tet[forward ? q : p];
          around.cut_offset[t][e] = lower == tet[at] ? 0 : slot_offset(l, lower - tet[at], parity);
          around.cut_family[t][e] = family_of(upper - lower);
        }
    }
  return around;
}

}  // namespace turgor::lattice
