// Forces of cloth on a body of chains: they displace all vertices like a half space of the chain's stiffness.
#include <algorithm>

#include "turgor/models/rhombus/spread.hpp"
#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"

namespace turgor {

namespace {

// Between a tool and chains, the force of a sheet may return up to 1.4 times as large one frame later, for
// any mass. A relaxation p is stable for p (1 + 1.4) < 2.
constexpr double kLargestRelaxation = 0.25;

/// Forces on a body of the model's stiffness that give the same displacement.
std::vector<rhombus::Load> loads_of(std::span<const contact::VertexForce> forces, double stiffness_scale) {
  std::vector<rhombus::Load> loads;
  for (const auto& [vertex, force] : forces) loads.push_back({vertex, force / stiffness_scale});
  return loads;
}

}  // namespace

void press_body(const Exec& exec, RhombusBody& body, const ClothForces& push, double dt) {
  if (push.force.empty() && body.state.carried.empty()) return;
  relax_toward(push, body.cloth);
  const std::vector<rhombus::Load> loads = loads_of(body.cloth.force, body.stiffness_scale);
  rhombus::displacements_of(exec, body.model, loads, body.state.carried);
  const double sum = sum_of_norms(body.cloth),
               compliance = sum > 0 ? rhombus::farthest_move(exec, body.model, loads) / sum : 0;
  body.cloth.compliance = {compliance, compliance, compliance};
  choose_relaxation(push.mass, dt, body.cloth);
  body.cloth.relaxation = std::min(body.cloth.relaxation, kLargestRelaxation);
}

}  // namespace turgor
