// Layers of tissue on the walls of wounds, for pictures. The walls are subdivided, and each vertex has the
// layer in which it lies at rest. Depth counts from the drawn skin, unlike in the law, whose layers begin at
// the outermost nodes (cell_laws.hpp).
#pragma once

#include <span>
#include <vector>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor {

/// True if a layer of the body has a color.
bool has_layer_colors(const LatticeBody& body);

/// Rest surface of a body with its walls.
struct RestWalls {
  std::span<const Vec3d> rest;  // of the vertices, patient frame [m]
  std::span<const Int3> skin, walls;
};

/// Layers on the walls. Empty without walls.
WallLayers layers_on_walls(const Exec& exec, const LatticeBody& body, const RestWalls& surface);

}  // namespace turgor
