#include "turgor/models/cloth/obstacle.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor::cloth {

Obstacle plane_obstacle(Vec3d through, Vec3d normal) {
  const Vec3 n(normalized(normal));
  const Real height = dot(n, Vec3(through));
  return {.nearest = [n, height](Vec3 x, Real reach, SurfacePoint& found) {
    found = {.distance = dot(n, x) - height, .normal = n, .velocity = {}};
    return found.distance < reach;
  }};
}

std::shared_ptr<const MovingSurface> moving_surface(const TriMesh& mesh, const std::vector<Vec3>& after,
                                                    double dt) {
  std::vector<Vec3d> vertices;
  for (const Vec3 x : mesh.vertices) vertices.push_back(Vec3d(x));
  auto surface = std::make_shared<MovingSurface>();
  surface->tree = build_triangle_tree(std::move(vertices), mesh.triangles);
  surface->normals = vertex_normals(mesh);
  for (std::size_t v = 0; v < after.size(); v++)
    surface->velocities.push_back((after[v] - mesh.vertices[v]) / Real(dt));
  return surface;
}

Obstacle surface_obstacle(std::shared_ptr<const MovingSurface> surface) {
  return {.nearest = [surface](Vec3 x, Real reach, SurfacePoint& found) {
    const TriangleTree& tree = surface->tree;  // no structured bindings: Clang 14 cannot capture them
    const auto &normals = surface->normals, &velocities = surface->velocities;
    const double depth = surface->depth;
    const double far = std::max(double(reach), depth);
    const auto corner = [&tree](int v) { return tree.vertices[std::size_t(v)]; };
    TrianglePoint at;
    const int item = nearest_item(tree.boxes, Vec3d(x), far * far, [&](int t, double best) {
      const auto [a, b, c] = tree.triangles[std::size_t(t)];
      TrianglePoint p = nearest_on_triangle(Vec3d(x), corner(a), corner(b), corner(c));
      const double d2 = p.distance * p.distance;
      if (d2 < best) p.triangle = t, at = p;
      return d2;
    });
    if (item < 0) return false;
    const Int3 t = tree.triangles[std::size_t(at.triangle)];
    Vec3d normal;
    for (int k = 0; k < 3; k++) normal += Vec3d(normals[std::size_t(t[k])]) * at.weights[k];
    const Vec3d away = Vec3d(x) - at.place;
    const double side = dot(away, normal) >= 0 ? 1 : -1;
    const bool is_on_it = !(at.distance > 1e-9 * far);
    found.distance = Real(side * at.distance);
    found.normal = Vec3(is_on_it ? normalized(normal) : normalized(away) * side);
    found.velocity = {};
    if (!velocities.empty())
      for (int k = 0; k < 3; k++) found.velocity += velocities[std::size_t(t[k])] * Real(at.weights[k]);
    return found.distance < reach;
  }};
}

// The contacts were found before the cloth moved: there, the vertices are looked for.
void add_surface_impulses(const State& state, int obstacle, const MovingSurface& surface, double dt,
                          std::span<Vec3d> impulse) {
  TURGOR_ASSERT(impulse.size() == surface.tree.vertices.size(), "one impulse a vertex");
  for (const Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle || !(c.impulse > 0)) continue;
    const auto v = std::size_t(c.vertex[0]);
    const TrianglePoint at = nearest_point(surface.tree, Vec3d(state.x[v]) - Vec3d(state.v[v]) * dt);
    const Int3 t = surface.tree.triangles[std::size_t(at.triangle)];
    for (int k = 0; k < 3; k++) impulse[std::size_t(t[k])] += impulse_on_obstacle(c) * at.weights[k];
  }
}

}  // namespace turgor::cloth
