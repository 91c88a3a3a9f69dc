// Cloth on a body of chains: what it weighs moves every vertex, as it does a half space as soft as the chain.
#include <algorithm>

#include "turgor/models/rhombus/spread.hpp"
#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"

namespace turgor {

namespace {

// Between a tool and chains a sheet's force may come back 1.4 times as large a frame later, whatever the
// sheet weighs: a part p of it stays bounded while p (1 + 1.4) < 2.
constexpr double kMostTaken = 0.25;

std::vector<rhombus::Load> loads_of(std::span<const contact::VertexForce> forces) {
  std::vector<rhombus::Load> loads;
  for (const auto& [vertex, force] : forces) loads.push_back({vertex, force});
  return loads;
}

}  // namespace

void press_body(const Exec& exec, RhombusBody& body, const ClothPush& push, double dt) {
  if (push.force.empty() && body.state.carried.empty()) return;
  take_over(push, body.cloth);
  const std::vector<rhombus::Load> loads = loads_of(body.cloth.force);
  rhombus::displacements_of(exec, body.model, loads, body.state.carried);
  const double sum = sum_of_sizes(body.cloth),
               answer = sum > 0 ? rhombus::farthest_move(exec, body.model, loads) / sum : 0;
  body.cloth.answer = {answer, answer, answer};
  choose_part(push.mass, dt, body.cloth);
  body.cloth.part = std::min(body.cloth.part, kMostTaken);
}

}  // namespace turgor
