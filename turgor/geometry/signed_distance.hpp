// Shapes as functions of place: the signed distance to a closed triangle surface, and a smoothed one to
// voxels, such as those of a label, whose zero level keeps their volume. stuffing.hpp fills them with
// tetrahedra.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Negative inside, positive outside, zero on the surface, and about as steep as a distance near it.
struct SignedDistance {
  std::function<double(Vec3d)> at;  // [m]; any thread may call it
  Vec3d low, high;                  // a box around all that is inside [m]
};

/// The exact distance to a closed surface; inside is what it winds around (winding_number.hpp), whichever way
/// round its triangles are, also where it crosses itself.
SignedDistance distance_to_surface(const TriMesh& surface);

/// The distance to the voxels that are set (1; the others 0), smoothed by a Gaussian of this standard
/// deviation [m], then shifted so that the inside has the voxels' volume. What is beyond the grid is outside.
/// At least one voxel is set.
SignedDistance distance_to_voxels(const Exec& exec, const Grid& grid, const std::vector<std::uint8_t>& inside,
                                  double smoothing);

}  // namespace turgor
