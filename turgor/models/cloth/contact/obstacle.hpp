// What a cloth must stay out of, besides itself: planes and triangle surfaces that may move. Shapes of tools
// are in contact/cloth_obstacle.hpp.
#pragma once

#include <memory>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Everything on the far side of a plane.
Obstacle plane_obstacle(Vec3d through, Vec3d normal);

/// A surface of triangles, counter-clockwise seen from outside, that moves with its vertices. It need not be
/// closed: its outside is where its normals point.
struct MovingSurface {
  TriangleTree tree;
  std::vector<Vec3> normals;     // of the vertices: which side is outside
  std::vector<Vec3> velocities;  // of the vertices [m/s]
  double depth = 0.02;           // vertices deeper below the surface are left alone [m]
};
/// `after` are the places of the vertices when a step of dt ends; empty = it is at rest.
std::shared_ptr<const MovingSurface> moving_surface(const TriMesh& mesh, const std::vector<Vec3>& after,
                                                    double dt);
Obstacle surface_obstacle(std::shared_ptr<const MovingSurface> surface);

/// Adds the impulses that a surface got in the latest step, `obstacle` of its inputs, to the vertices of the
/// triangles where they act, by barycentric weights [N·s].
void add_surface_impulses(const State& state, int obstacle, const MovingSurface& surface, double dt,
                          std::span<Vec3d> impulse);

}  // namespace turgor::cloth
