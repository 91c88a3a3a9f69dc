// Sheets of cloth above each other on a table, for tests and benches.
#pragma once

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {

constexpr double kStackCell = 0.01, kStackThickness = 0.004;  // [m]

/// Horizontal sheets above each other, of side × side vertices, each turned a little and shifted, so that
/// their meshes are not aligned. `gap` is their distance at the start [m].
struct Stack {
  Model model;
  State state;
  Inputs inputs = in_vacuum();
};
inline Stack make_stack(int layers, int side, double gap, Method method) {
  constexpr Pattern kMeshes[] = {Pattern::kAlternating, Pattern::kRandom, Pattern::kDiagonal};
  const double length = kStackCell * (side - 1);
  TriMesh mesh;
  for (int layer = 0; layer < layers; layer++) {
    const TriMesh sheet = rectangle(kMeshes[layer % 3], 0, length, length, kStackCell);
    const int first = int(mesh.vertices.size());
    // at rest the sheets are far apart, so that they count as layers
    for (const Vec3 x : sheet.vertices) mesh.vertices.push_back(x + Vec3{0, 0, Real(0.1 * layer)});
    for (const Int3 t : sheet.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  }
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = method}};
  if (method == Method::kTwoLevel) params.solver.sweeps = 200;
  params.collision.thickness = kStackThickness;
  Stack stack{.model = must_build(mesh, params), .state = {}};
  stack.state = make_state(stack.model);
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    const int layer = int(v) / (side * side);
    const double angle = 0.05 * layer, c = std::cos(angle), s = std::sin(angle);
    const Vec3d x(mesh.vertices[v]), from_center = x - Vec3d{length / 2, length / 2, x.z};
    const Vec3d turned{c * from_center.x - s * from_center.y, s * from_center.x + c * from_center.y,
                       kStackThickness / 2 + gap * layer};
    stack.state.x.set(std::size_t(stack.model.model_vertex[v]), Vec3(turned));
  }
  stack.inputs.obstacles.push_back(plane_obstacle({0, 0, 0}, {0, 0, 1}));
  return stack;
}

}  // namespace turgor::cloth
