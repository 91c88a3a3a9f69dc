// Cloth on a body: what it weighs moves every vertex, u = Ξ f, and the ticks of the next frame go there.
#include <algorithm>

#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

namespace {

/// By the factor, all vertices.
std::vector<Vec3d> solved(const sfem::Model& model, std::span<const contact::VertexForce> forces) {
  std::vector<double> u(3 * model.vertex.size());
  for (const auto& [vertex, force] : forces) {
    const int row = model.free_node[std::size_t(vertex)];
    if (row < 0) continue;
    for (int axis = 0; axis < 3; axis++) u[3 * std::size_t(row) + std::size_t(axis)] += force[axis];
  }
  sfem::solve(*model.factor, u);
  std::vector<Vec3d> displacement(model.body.mesh.vertices.size());
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    displacement[std::size_t(model.vertex[row])] = {u[3 * row], u[3 * row + 1], u[3 * row + 2]};
  return displacement;
}

/// Whether a factor is at hand besides Green's functions depends on the cache; whether it must be, on the
/// scene alone.
std::vector<Vec3d> answer(const Exec& exec, const SfemBody& body,
                          std::span<const contact::VertexForce> forces) {
  const bool has_factor = body.facts.on_demand || body.turning;
  std::vector<Vec3d> u = has_factor ? solved(body.model, forces) : displacements(exec, body, forces);
  if (body.stiffer != 1)
    for (Vec3d& one : u) one = one / body.stiffer;
  return u;
}

/// How softly the body answers this load along one axis: one a frame.
void measure_answer(const Exec& exec, const SfemBody& body, ClothLoad& load) {
  const double sum = sum_of_sizes(load);
  if (sum == 0) return;
  double largest = 0;
  for (const Vec3d u : answer(exec, body, forces_along(load, load.axis)))
    largest = std::max(largest, norm(u));
  load.answer[load.axis] = largest / sum;
  load.axis = (load.axis + 1) % 3;
}

}  // namespace

void sum_free_motion(SfemBody& body) {
  if (!body.turning && !body.press) return;
  std::vector<Vec3d>& now = body.free.now;
  now = body.turning ? body.turning->state.free : body.press->displacement;
  if (body.free.before.empty()) body.free.before.resize(now.size());
  if (body.turning && body.press)
    for (std::size_t v = 0; v < now.size(); v++) now[v] += body.press->displacement[v];
}

void press_body(const Exec& exec, SfemBody& body, const ClothPush& push, double dt) {
  if (!body.press && push.force.empty()) return;
  if (!body.press) body.press = ClothPress{{}, std::vector<Vec3d>(body.model.body.mesh.vertices.size())};
  ClothPress& press = *body.press;
  take_over(push, press.load);
  press.displacement = answer(exec, body, press.load.force);
  measure_answer(exec, body, press.load);
  choose_part(push.mass, dt, press.load);
  sum_free_motion(body);
}

}  // namespace turgor
