// Triangle meshes of tools, for drawing.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Capsule around the segment from -half_length to half_length on the z axis; a ball for half_length 0 [m].
TriMesh capsule_mesh(double radius, double half_length);

/// Needle with its tip at the origin and its shaft along z [m].
TriMesh needle_mesh(double diameter, double cone, double length);

/// Arrow from `tail` to `tip` with a conical head [m].
TriMesh arrow_mesh(Vec3d tail, Vec3d tip, double thickness);

}  // namespace turgor
