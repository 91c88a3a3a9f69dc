// What surrounds a node of the lattice: fourteen neighbours, and twenty-four tetrahedra whose other corners
// are among them. Where the neighbours are in memory depends only on whether the node's i is even or odd;
// which of them make a tetrahedron does not change at all.
#pragma once

#include <array>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

constexpr int kNeighborCount = 14;

/// Neighbour 2 f is forward along family f, 2 f + 1 backward.
constexpr Int3 neighbor_offset(int n) {
  const Int3 family = kFamilies[std::size_t(n / 2)];
  return n % 2 == 0 ? family : -family;
}
constexpr int neighbor_at(Int3 offset) {
  for (int n = 0; n < kNeighborCount; n++)
    if (neighbor_offset(n) == offset) return n;
  return -1;
}

/// An edge of a tetrahedron, seen from a node: its lower end (a neighbour, or -1 for the node itself) and its
/// family.
struct EdgeAround {
  int lower = -1, family = 0;
};

/// A tetrahedron around a node: its other corners as neighbours, positively oriented with the node first.
struct TetAround {
  int corner[3];
  int far[2];  // the two ends of the cell's diagonal, -1 = the node itself
  EdgeAround edge[6];
};

constexpr std::array<TetAround, 24> make_tets_around() {
  constexpr int kEvenOrder[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
  std::array<TetAround, 24> around{};
  std::size_t t = 0;
  for (const auto& tet : kKuhnTets)
    for (std::size_t at = 0; at < 4; at++, t++) {
      const auto neighbor = [&](std::size_t corner) {
        return corner == at ? -1 : neighbor_at(tet[corner] - tet[at]);
      };
      for (std::size_t c = 0; c < 3; c++) around[t].corner[c] = neighbor(std::size_t(kEvenOrder[at][c + 1]));
      around[t].far[0] = neighbor(0), around[t].far[1] = neighbor(3);
      std::size_t e = 0;
      for (std::size_t p = 0; p < 4; p++)
        for (std::size_t q = p + 1; q < 4; q++, e++) {
          const bool forward = family_of(tet[q] - tet[p]) >= 0;
          around[t].edge[e] = {neighbor(forward ? p : q),
                               family_of(forward ? tet[q] - tet[p] : tet[p] - tet[q])};
        }
    }
  return around;
}
inline constexpr std::array<TetAround, 24> kTetsAround = make_tets_around();

/// The neighbours of a node whose i has one parity.
struct Neighbors {
  int offset[kNeighborCount];  // in slots
  Vec3 edge[kNeighborCount];   // rest vector to the neighbour [m]
  Real rest[kNeighborCount];   // its length [m]
  Real scale[kNeighborCount];  // of the spring, Model::spring_scale [m]
};
Neighbors neighbors_of(const Model& model, int parity);

}  // namespace turgor::lattice
