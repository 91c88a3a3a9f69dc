#include "turgor/models/cloth/build/change_fabric.hpp"

#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/build/build.hpp"

namespace turgor::cloth {

bool change_fabric(const Exec& exec, const Fabric& fabric, const std::vector<Int3>& triangles, Model& model,
                   State& state) {
  TURGOR_ASSERT(fabric.law == model.params.fabric.law, "a cloth keeps its law");
  TURGOR_CHECK(all_indices(model.model_vertex, model.x_rest.size()), "vertices of the mesh are in the model");
  // mesh at rest
  TriMesh mesh{.triangles = triangles};
  for (const int v : model.model_vertex) mesh.vertices.push_back(model.x_rest[std::size_t(v)]);
  // model
  Params params = model.params;
  params.fabric = fabric;
  Result<Model> built = build(exec, mesh, params);
  if (!built || built->model_vertex != model.model_vertex || built->mass.size() != model.mass.size() ||
      built->rows.stiffness.size() != model.rows.stiffness.size() ||
      built->far_rows.bend.size() != model.far_rows.bend.size())
    return false;
  model = std::move(*built);
  // masses of vertices that are not held
  for (std::size_t v = 0; v < model.mass.size(); v++)
    if (state.free_mass[v] > 0) state.free_mass[v] = model.mass[v];
  return true;
}

}  // namespace turgor::cloth
