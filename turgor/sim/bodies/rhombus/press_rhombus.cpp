// Forces of cloth and of other bodies on a body of chains: they displace all vertices like a half space of
// the chain's stiffness.
#include <algorithm>

#include "turgor/models/rhombus/spread.hpp"
#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"

namespace turgor {

namespace {

/// Forces on a body of the model's stiffness that give the same displacement.
std::vector<rhombus::Load> loads_of(std::span<const contact::VertexForce> forces, double stiffness_scale) {
  std::vector<rhombus::Load> loads;
  for (const auto& [vertex, force] : forces) loads.push_back({vertex, force / stiffness_scale});
  return loads;
}

}  // namespace

std::vector<Vec3d> displacement_without(const Exec& exec, const RhombusBody& body,
                                        std::span<const contact::VertexForce> forces) {
  std::vector<Vec3d> without = body.state.displacement, by_forces;
  if (forces.empty()) return without;
  rhombus::displacements_of(exec, body.model, loads_of(forces, body.stiffness_scale), by_forces);
  for (std::size_t v = 0; v < without.size(); v++) without[v] -= by_forces[v];
  return without;
}

void press_body(const Exec& exec, RhombusBody& body, const ClothForces& push, double dt) {
  if (push.force.empty() && push.solved.empty() && body.state.carried.empty()) return;
  relax_toward(push, body.cloth);
  const std::vector<rhombus::Load> loads = loads_of(body.cloth.force, body.stiffness_scale);
  std::vector<rhombus::Load> all = loads_of(push.solved, body.stiffness_scale);
  all.insert(all.end(), loads.begin(), loads.end());
  rhombus::displacements_of(exec, body.model, all, body.state.carried);
  const double sum = sum_of_norms(body.cloth),
               compliance = sum > 0 ? rhombus::farthest_move(exec, body.model, loads) / sum : 0;
  body.cloth.compliance = {compliance, compliance, compliance};
  choose_relaxation(push.mass, dt, body.cloth);
  body.cloth.relaxation = std::min(body.cloth.relaxation, kLargestRelaxation);
}

}  // namespace turgor
