// Shapes as implicit functions: the signed distance to a closed triangle surface, and a smoothed signed
// distance to voxels (such as a label) whose zero level keeps their volume. The sign of surfaces comes from
// the generalized winding number. stuffing.hpp fills shapes with tetrahedra.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Negative inside, positive outside, zero on the surface, with a slope of about 1 near it.
struct SignedDistance {
  std::function<double(Vec3d)> at;  // [m]; any thread may call it
  Vec3d low, high;                  // box around the inside [m]
};

/// Exact distance to a closed surface. The inside is defined by the winding number (winding_number.hpp), for
/// either orientation of the triangles and for self-crossing surfaces.
SignedDistance distance_to_surface(const TriMesh& surface);

/// Distance to the set voxels (1; the others 0), smoothed by a Gaussian of this standard deviation [m], then
/// shifted so that the inside has the voxels' volume. Samples outside the grid are not set. At least one
/// voxel is set.
SignedDistance distance_to_voxels(const Exec& exec, const Grid& grid, const std::vector<std::uint8_t>& inside,
                                  double smoothing);

}  // namespace turgor
