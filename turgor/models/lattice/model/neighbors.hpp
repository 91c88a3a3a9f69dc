// Neighborhood of a node of the lattice: fourteen neighbors, and the twenty-four tetrahedra that contain the
// node. Memory offsets of neighbors depend only on the parity of the node's i. The tetrahedra are the same
// for every node.
#pragma once

#include <array>

#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

constexpr int kNeighborCount = 14;

/// Neighbor 2 f is forward along family f; 2 f + 1 is backward.
constexpr Int3 neighbor_offset(int n) {
  const Int3 family = kFamilies[std::size_t(n / 2)];
  return n % 2 == 0 ? family : -family;
}
/// Index of the neighbor at an offset; -1 = none.
constexpr int neighbor_at(Int3 offset) {
  for (int n = 0; n < kNeighborCount; n++)
    if (neighbor_offset(n) == offset) return n;
  return -1;
}

/// Edge of a tetrahedron relative to a node: its lower end (a neighbor; -1 = the node itself) and its family.
struct IncidentEdge {
  int lower = -1, family = 0;
};

/// Tetrahedron that contains a node: its other corners as neighbors, positively oriented with the node first.
struct IncidentTet {
  int corner[3];
  int far[2];  // ends of the cell's diagonal; -1 = the node itself
  IncidentEdge edge[6];
};

constexpr std::array<IncidentTet, 24> make_incident_tets() {
  constexpr int kEvenOrder[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
  std::array<IncidentTet, 24> tets{};
  std::size_t t = 0;
  for (const auto& tet : kKuhnTets)
    for (std::size_t at = 0; at < 4; at++, t++) {
      const auto neighbor = [&](std::size_t corner) {
        return corner == at ? -1 : neighbor_at(tet[corner] - tet[at]);
      };
      // corners
      for (std::size_t c = 0; c < 3; c++) tets[t].corner[c] = neighbor(std::size_t(kEvenOrder[at][c + 1]));
      tets[t].far[0] = neighbor(0), tets[t].far[1] = neighbor(3);
      // edges
      std::size_t e = 0;
      for (std::size_t p = 0; p < 4; p++)
        for (std::size_t q = p + 1; q < 4; q++, e++) {
          const bool forward = family_of(tet[q] - tet[p]) >= 0;
          tets[t].edge[e] = {neighbor(forward ? p : q),
                             family_of(forward ? tet[q] - tet[p] : tet[p] - tet[q])};
        }
    }
  return tets;
}
inline constexpr std::array<IncidentTet, 24> kIncidentTets = make_incident_tets();

/// Neighbors of a node with one parity of i.
struct Neighbors {
  int offset[kNeighborCount];  // [slots]
  Vec3 edge[kNeighborCount];   // rest vector to the neighbor [m]
  Real rest[kNeighborCount];   // its length [m]
  Real scale[kNeighborCount];  // Springs::scale [m]
};
Neighbors neighbors_of(const Model& model, int parity);

}  // namespace turgor::lattice
