// Forces of cloth on a body: they displace all vertices by u = Ξ f, which the ticks of the next frame
// approach.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

namespace {

/// Displacement under forces. The choice between factor and Green's functions depends on the scene only,
/// although the cache may provide a factor.
std::vector<Vec3d> displacement_under(const Exec& exec, const SfemBody& body,
                                      std::span<const contact::VertexForce> forces) {
  const bool has_factor = body.facts.on_demand || body.turning;
  std::vector<Vec3d> u =
      has_factor ? displacement_by_factor(body.model, forces) : displacements(exec, body, forces);
  TURGOR_CHECK(!(body.stiffness_scale <= 0), "a body has a stiffness");  // NaN is undone later
  if (body.stiffness_scale != 1)
    for (Vec3d& one : u) one = one / body.stiffness_scale;
  return u;
}

/// Measures the compliance of the body under this load along one axis per frame.
void measure_compliance(const Exec& exec, const SfemBody& body, ClothLoad& load) {
  const double sum = sum_of_norms(load);
  TURGOR_CHECK(load.next_axis >= 0 && load.next_axis < 3, "a compliance is measured along one of three axes");
  if (sum == 0) return;
  double largest = 0;
  for (const Vec3d u : displacement_under(exec, body, forces_along(load, load.next_axis)))
    largest = std::max(largest, norm(u));
  load.compliance[load.next_axis] = largest / sum;
  load.next_axis = (load.next_axis + 1) % 3;
}

}  // namespace

std::vector<Vec3d> displacement_by_factor(const sfem::Model& model,
                                          std::span<const contact::VertexForce> forces) {
  TURGOR_ASSERT(model.factor.has_value(), "displacements are solved with the factor");
  // assemble the right-hand side at free nodes
  std::vector<double> u(3 * model.vertex.size());
  for (const auto& [vertex, force] : forces) {
    TURGOR_CHECK(is_index(vertex, model.free_node.size()), "forces act on vertices of the body");
    const int row = model.free_node[std::size_t(vertex)];
    if (row < 0) continue;
    for (int axis = 0; axis < 3; axis++) u[3 * std::size_t(row) + std::size_t(axis)] += force[axis];
  }
  // solve
  sfem::solve(*model.factor, u);
  // scatter to all vertices; fixed ones stay at rest
  std::vector<Vec3d> displacement(model.body.mesh.vertices.size());
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    displacement[std::size_t(model.vertex[row])] = {u[3 * row], u[3 * row + 1], u[3 * row + 2]};
  return displacement;
}

void sum_free_motion(SfemBody& body) {
  const bool has_needles = body.touch.needles.inner != nullptr;
  if (!body.turning && !body.press && !has_needles) return;
  const std::size_t count = body.model.body.mesh.vertices.size();
  std::vector<Vec3d>& now = body.free.now;
  now.assign(count, {});
  if (body.free.before.empty()) body.free.before.resize(count);
  const auto add = [&](const std::vector<Vec3d>& u) {
    TURGOR_CHECK(u.empty() || u.size() == count, "every vertex has a displacement");
    for (std::size_t v = 0; v < u.size(); v++) now[v] += u[v];
  };
  if (body.turning) add(body.turning->state.free);
  if (body.press) add(body.press->displacement);
  for (const std::vector<Vec3d>& u : body.needles.displacement) add(u);
}

void press_body(const Exec& exec, SfemBody& body, const ClothForces& push, double dt) {
  if (!body.press && push.force.empty()) return;
  if (!body.press) body.press = ClothPress{{}, std::vector<Vec3d>(body.model.body.mesh.vertices.size())};
  ClothPress& press = *body.press;
  relax_toward(push, press.load);
  press.displacement = displacement_under(exec, body, press.load.force);
  measure_compliance(exec, body, press.load);
  choose_relaxation(push.mass, dt, press.load);
  sum_free_motion(body);
}

}  // namespace turgor
