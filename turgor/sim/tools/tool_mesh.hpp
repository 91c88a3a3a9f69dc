// Tools as triangles, to be drawn.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Around the segment from -half_length to half_length on the z axis; a ball when that is 0 [m].
TriMesh capsule_mesh(double radius, double half_length);

/// From a point towards `tip`, with a cone as its head [m].
TriMesh arrow_mesh(Vec3d tail, Vec3d tip, double thickness);

}  // namespace turgor
