// Obstacles of a cloth: planes and moving triangle surfaces. Shapes of tools are in
// contact/cloth_obstacle.hpp.
#pragma once

#include <memory>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Half-space below the plane through a point.
Obstacle plane_obstacle(Vec3d through, Vec3d normal);

/// Triangle surface whose vertices move; triangles are counter-clockwise seen from outside. It may be open:
/// outside is the side of its normals.
struct MovingSurface {
  TriangleTree tree;
  std::vector<Vec3> normals;     // of the vertices, outward
  std::vector<Vec3> velocities;  // of the vertices [m/s]
  double depth = 0.02;           // vertices deeper below the surface are ignored [m]
};
/// Surface that moves from the mesh to the vertex positions `after` in dt; empty `after`: at rest.
std::shared_ptr<const MovingSurface> moving_surface(const TriMesh& mesh, const std::vector<Vec3>& after,
                                                    double dt);
Obstacle surface_obstacle(std::shared_ptr<const MovingSurface> surface);

/// Distributes the impulses on a surface in the latest step to the vertices of the triangles they act on, by
/// barycentric weights [N·s]. `obstacle` is its index in the inputs.
void add_surface_impulses(const State& state, int obstacle, const MovingSurface& surface, double dt,
                          std::span<Vec3d> impulse);

}  // namespace turgor::cloth
