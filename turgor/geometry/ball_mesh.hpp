// Triangles of a ball.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// An octahedron around the origin, every triangle cut in four `halvings` times and pushed onto the ball:
/// 8 · 4^halvings triangles, without normals and scalars. `radius` [m].
TriMesh ball_mesh(double radius, int halvings);

}  // namespace turgor
