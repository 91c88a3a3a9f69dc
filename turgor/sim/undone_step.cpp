#include "turgor/sim/undone_step.hpp"

#include <cmath>

#include <fmt/format.h>

#include "turgor/sim/world.hpp"

namespace turgor {

std::string advice_for_undone_step(const World& world) {
  // an undone step of a cloth has a speed that is not finite
  for (const ClothBody& body : world.cloth_bodies)
    if (!body.samples.empty() && !std::isfinite(body.samples.back().largest_speed))
      return fmt::format("{}: a higher frame rate or a smaller stiffness of its fabric may help", body.name);
  // skin tension is a parameter of lattices only
  if (!world.lattice_bodies.empty())
    return "more solver.sweeps, a higher frame rate or a smaller skin tension may help";
  return "a higher frame rate may help";
}

}  // namespace turgor
