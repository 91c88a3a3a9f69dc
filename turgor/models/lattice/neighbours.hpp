// What surrounds a node of the lattice, as constant distances in memory: fourteen springs and twenty-four tetrahedra. They depend only
// on whether the node's i is even or odd.
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// The fourteen neighbours of a node whose i has one parity: seven families, both ways.
struct Neighbours {
  int offset[14];
  Vec3 edge[14];  // rest vector to the neighbour [m]
  Real rest[14], scale[14];
};

/// The twenty-four tetrahedra around a node: offsets and rest vectors of the other three corners, positively oriented.
struct TetsAround {
  struct Corner {
    int offset[3];
    Vec3 edge[3];
  };
  Corner tet[24];
  // the six edges of each: where the lower end is, relative to the node, and the family
  int cut_offset[24][6], cut_family[24][6];
};

Neighbours neighbours_of(const Model& model, int parity);
TetsAround tets_of(const Lattice& lattice, int parity);

}  // namespace turgor::lattice
