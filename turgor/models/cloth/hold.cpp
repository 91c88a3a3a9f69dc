#include "turgor/models/cloth/hold.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::cloth {

namespace {

auto find_hold(std::vector<Hold>& holds, int vertex) {
  TURGOR_CHECK(is_sorted_unique(holds, &Hold::vertex), "holds ascend by vertex");
  return std::lower_bound(holds.begin(), holds.end(), vertex,
                          [](const Hold& hold, int v) { return hold.vertex < v; });
}

Result<int> model_vertex_of(const Model& model, int mesh_vertex) {
  const int count = int(model.model_vertex.size());
  if (mesh_vertex < 0 || mesh_vertex >= count)
    return Error{"expected a vertex from 0 to " + std::to_string(count - 1) + ", found " +
                 std::to_string(mesh_vertex)};
  return model.model_vertex[std::size_t(mesh_vertex)];
}

Error not_held(int mesh_vertex) { return {"vertex " + std::to_string(mesh_vertex) + " is not held"}; }

}  // namespace

Status hold(const Model& model, State& state, int mesh_vertex) {
  const Result<int> v = model_vertex_of(model, mesh_vertex);
  if (!v) return v.error();
  const auto at = find_hold(state.holds, *v);
  if (at != state.holds.end() && at->vertex == *v) return Done{};
  state.holds.insert(at, {*v, state.x[std::size_t(*v)]});
  state.free_mass[std::size_t(*v)] = 0;
  return Done{};
}

Status move_hold(const Model& model, State& state, int mesh_vertex, Vec3 goal) {
  const Result<int> v = model_vertex_of(model, mesh_vertex);
  if (!v) return v.error();
  const auto at = find_hold(state.holds, *v);
  if (at == state.holds.end() || at->vertex != *v) return not_held(mesh_vertex);
  at->goal = goal;
  return Done{};
}

Status release(const Model& model, State& state, int mesh_vertex) {
  const Result<int> v = model_vertex_of(model, mesh_vertex);
  if (!v) return v.error();
  const auto at = find_hold(state.holds, *v);
  if (at == state.holds.end() || at->vertex != *v) return not_held(mesh_vertex);
  state.holds.erase(at);
  state.free_mass[std::size_t(*v)] = model.mass[std::size_t(*v)];
  return Done{};
}

}  // namespace turgor::cloth
