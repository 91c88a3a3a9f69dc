// Where the points of a tetrahedron's polygons (marching_tets.hpp) lie: on the skin, on the blade, and where
// the two meet.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/surface/marching_tets.hpp"

namespace turgor::lattice {

/// One tetrahedron of the fine lattice.
struct FineTet {
  const Fragments& pieces;
  const State& state;
  std::array<Int3, 4> nodes = {};           // of the fine lattice
  std::array<std::uint64_t, 4> index = {};  // theirs
  std::array<double, 4> level = {};         // at the nodes: more than 0 in tissue; the skin is where it is 0
  bool is_near_cut = false;
};

/// Where the blade crosses the skin between those of the edges ib and jb, i and j on its two sides: on the
/// line through where it crosses ij and the one of ib and jb that it must cross as well.
struct Clip {
  Vec3d place;       // [steps of the lattice]
  double along = 0;  // on the blade's path [m]
  std::uint8_t incision = 0;
  bool rightward = false;  // from i to j
};
Clip clip_between(const FineTet& tet, int i, int j, int b);

/// In steps of the lattice.
Vec3d place_of(const FineTet& tet, TetPoint p);

}  // namespace turgor::lattice
