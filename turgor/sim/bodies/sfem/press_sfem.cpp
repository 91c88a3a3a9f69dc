// Forces of cloth, of attachments and of other bodies on a body: they displace all vertices by u = Ξ f, which
// the ticks of the next frame approach. A body without fixed vertices also moves by its inertia.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

namespace {

void add(const std::vector<Vec3d>& more, std::vector<Vec3d>& sum) {
  TURGOR_CHECK(more.size() == sum.size(), "every vertex has both displacements");
  for (std::size_t v = 0; v < sum.size(); v++) sum[v] += more[v];
}

/// Displacement under forces. The choice between factor and Green's functions depends on the scene only,
/// although the cache may provide a factor.
std::vector<Vec3d> displacement_under(const Exec& exec, const SfemBody& body,
                                      std::span<const contact::VertexForce> forces) {
  const bool has_factor = body.facts.on_demand || body.turning || body.flight;
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
  const bool has_needles = body.needles.inner != nullptr;
  if (!body.turning && !body.press && !body.coupling && !body.flight && !has_needles) return;
  const std::size_t count = body.model.body.mesh.vertices.size();
  body.free.now = uncoupled_displacement(body, std::vector<Vec3d>(count));
  if (body.coupling) add(body.coupling->displacement, body.free.now);
  if (body.free.before.empty()) body.free.before.resize(count);
}

std::vector<Vec3d> tool_displacement(const Exec& exec, const SfemBody& body) {
  const std::vector<contact::VertexForce> forces = coarse_forces_now(body);
  if (forces.empty()) return std::vector<Vec3d>(body.model.body.mesh.vertices.size());
  return body.flight ? displacement_by_factor(body.model, forces) : displacements(exec, body, forces);
}

std::vector<Vec3d> uncoupled_displacement(const SfemBody& body, std::vector<Vec3d> by_tools) {
  if (body.turning) add(body.turning->state.free, by_tools);
  if (body.press) add(body.press->displacement, by_tools);
  if (body.flight) add(body.flight->displacement, by_tools);
  for (const std::vector<Vec3d>& u : body.needles.displacement)
    if (!u.empty()) add(u, by_tools);
  return by_tools;
}

void couple_body(const Exec& exec, SfemBody& body, std::vector<contact::VertexForce> forces) {
  body.coupling = CouplingLoad{std::move(forces), {}};
  body.coupling->displacement = displacement_under(exec, body, body.coupling->force);
  sum_free_motion(body);
}

void advance_flight(SfemBody& body, const std::vector<Vec3d>& by_tools, Vec3d gravity, double dt) {
  FreeFlight& flight = *body.flight;
  TURGOR_CHECK(is_step_length(dt) && body.model.mass.size() == flight.u.size(), "every vertex has a mass");
  // displacement at the end of the frame: the implicit step with all forces that acted in it
  std::vector<Vec3d> u = uncoupled_displacement(body, by_tools);
  if (body.coupling) add(body.coupling->displacement, u);
  for (std::size_t v = 0; v < u.size(); v++) flight.v[v] = (u[v] - flight.u[v]) / dt;
  flight.u = std::move(u);
  // next frame without other forces
  std::vector<contact::VertexForce> inertia;
  for (std::size_t v = 0; v < flight.u.size(); v++) {
    const Vec3d ahead = flight.u[v] + dt * flight.v[v];
    inertia.push_back({int(v), body.model.mass[v] * (ahead / (dt * dt) + gravity)});
  }
  flight.displacement = displacement_by_factor(body.model, inertia);
}

void press_body(const Exec& exec, SfemBody& body, const ClothForces& push, double dt) {
  if (!body.press && push.force.empty()) return;
  if (!body.press) body.press = ClothPress{{}, std::vector<Vec3d>(body.model.body.mesh.vertices.size())};
  ClothPress& press = *body.press;
  relax_toward(push, press.load);
  std::vector<Vec3d> displacement = displacement_under(exec, body, press.load.force);
  // the frame that ends had the former load
  if (body.flight)
    for (std::size_t v = 0; v < displacement.size(); v++)
      body.flight->displacement[v] += press.displacement[v] - displacement[v];
  press.displacement = std::move(displacement);
  measure_compliance(exec, body, press.load);
  choose_relaxation(push.mass, dt, press.load);
  press.load.relaxation = std::min(press.load.relaxation, kLargestRelaxation);
  sum_free_motion(body);
}

}  // namespace turgor
