#include "turgor/models/cloth/contact/obstacle.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

Obstacle plane_obstacle(Vec3d through, Vec3d normal) {
  const Vec3 n(normalized(normal));
  Obstacle plane;
  plane.shape.plane = {n, dot(n, Vec3(through))};
  return plane;
}

std::shared_ptr<const MovingSurface> moving_surface(const TriMesh& mesh, const std::vector<Vec3>& after,
                                                    double dt) {
  TURGOR_CHECK(after.empty() || after.size() == mesh.vertices.size(),
               "every vertex of a moving surface has a position after the step");
  std::vector<Vec3d> vertices;
  for (const Vec3 x : mesh.vertices) vertices.push_back(Vec3d(x));
  auto surface = std::make_shared<MovingSurface>();
  surface->tree = build_triangle_tree(std::move(vertices), mesh.triangles);
  surface->normals = vertex_normals(mesh);
  TURGOR_CHECK(after.empty() || is_step_length(dt), "a surface moves in a positive time");
  for (std::size_t v = 0; v < after.size(); v++)
    surface->velocities.push_back((after[v] - mesh.vertices[v]) / Real(dt));
  return surface;
}

Obstacle surface_obstacle(std::shared_ptr<const MovingSurface> surface) {
  TURGOR_ASSERT(surface != nullptr, "a surface obstacle has a surface");
  TURGOR_CHECK(surface->normals.size() == surface->tree.vertices.size(),
               "every vertex of a surface has a normal");
  TURGOR_CHECK(surface->velocities.empty() || surface->velocities.size() == surface->tree.vertices.size(),
               "every vertex of a moving surface has a velocity");
  // view of the surface data
  Obstacle obstacle;
  obstacle.shape.kind = ObstacleShape::Kind::kSurface;
  obstacle.shape.surface = {.boxes = view(surface->tree.boxes),
                            .vertices = surface->tree.vertices.data(),
                            .triangles = surface->tree.triangles.data(),
                            .normals = surface->normals.data(),
                            .velocities = surface->velocities.empty() ? nullptr : surface->velocities.data(),
                            .depth = surface->depth};
  // ownership of that data
  obstacle.moving = std::move(surface);
  return obstacle;
}

// Contacts were found before the motion, so vertices are taken at the beginning of the step.
void add_surface_impulses(const State& state, int obstacle, const MovingSurface& surface, double dt,
                          std::span<Vec3d> impulse) {
  TURGOR_ASSERT(impulse.size() == surface.tree.vertices.size(), "one impulse a vertex");
  for (const Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle || !(c.impulse > 0)) continue;
    const auto v = std::size_t(c.vertex[0]);
    const TrianglePoint at = nearest_point(surface.tree, Vec3d(state.x[v]) - Vec3d(state.v[v]) * dt);
    TURGOR_CHECK(is_index(at.triangle, surface.tree.triangles.size()), "a surface has a nearest triangle");
    const Int3 t = surface.tree.triangles[std::size_t(at.triangle)];
    for (int k = 0; k < 3; k++) impulse[std::size_t(t[k])] += impulse_on_obstacle(c) * at.weights[k];
  }
}

}  // namespace turgor::cloth
