// Positions of the points of marching_tets.hpp: on the skin, on the blade, and on the intersection of the
// two.
#pragma once

#include "turgor/models/lattice/surface/marching_tets.hpp"
#include "turgor/models/lattice/surface/onto_blades.hpp"

namespace turgor::lattice {

/// Tetrahedron of the fine lattice.
struct FineTet {
  const Fragments& fragments;
  const Cuts& cuts;
  LevelsNear& levels;
  std::span<const CutPoint> cut_points = {};  // around the cell
  std::array<Int3, 4> nodes = {};             // fine nodes
  std::array<std::uint64_t, 4> index = {};    // their fine indices
  std::array<double, 4> level = {};           // by node: positive in tissue, zero on the skin
  bool is_near_cut = false;
  bool has_several_blades = false;  // `cut_points` belong to several incisions
};

/// Intersection of the blade with the skin between the skin points of ib and jb, where i and j are on its two
/// sides. It lies on the blade's line from its crossing with ij to its crossing with ib or jb.
struct Clip {
  Vec3d position;                 // [cells]
  double along = 0;               // arc length on the blade's path [m]
  const CutEdge* edge = nullptr;  // cut edge ij
  bool rightward = false;         // from i to j
};
Clip clip_between(const FineTet& tet, int i, int j, int b);

/// Position of a point [cells].
Vec3d position_of(const FineTet& tet, TetPoint p);

}  // namespace turgor::lattice
