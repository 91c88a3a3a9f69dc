// Triangle mesh of a sphere by subdivision of an octahedron.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// An octahedron around the origin, `halvings` times subdivided one-to-four and projected onto the sphere: 8
/// · 4^halvings triangles, without normals and scalars. `radius` [m].
TriMesh ball_mesh(double radius, int halvings);

}  // namespace turgor
