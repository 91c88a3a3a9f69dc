#include "turgor/models/rhombus/tip.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::rhombus {

Tip tip_on(const Chain& chain, double radius) {
  if (chain.params.tip == 0) return {};
  const double effective_radius = std::max(radius, kSharpestTip);
  return {effective_radius, effective_radius / chain.params.tip};
}

DiscDepth disc_depth(const Tip& tip, double depth) {
  if (tip.radius == 0 || depth <= 0) return {depth, 1};
  // u = R x q^(1/4), x = d/R. Hertz gives q → x/c for small x, Sneddon u → d − R/2 for large x. q is the
  // simplest rational function with both limits.
  constexpr double c = 225.0 / 64;
  const double x = depth / tip.radius;
  const double over = x * (1 + 0.5 * x), under = c + x * (2 + 0.5 * x);
  const double root = std::sqrt(std::sqrt(over / under));
  const double growth = x * ((1 + x) / over - (2 + x) / under);  // d ln q / d ln x
  return {depth * root, root * (1 + 0.25 * growth)};
}

double chain_force(const Chain& chain, const Tip& tip, double depth, double guess) {
  TURGOR_CHECK(tip.scale > 0, "the scale of a tip is positive");
  return force_of_depth(chain, disc_depth(tip, depth).depth / tip.scale, guess);
}

double depth_of_tip(const Chain& chain, const Tip& tip, double force) {
  if (!(force > 0)) return 0;
  if (tip.radius == 0) return depth_of_force(chain, force).depth;
  // bracket, then bisection
  double low = 0, high = tip.radius;
  while (force_of_tip(chain, tip, high) < force && high < 1) low = high, high *= 2;
  for (int i = 0; i < 40; i++) {
    const double middle = 0.5 * (low + high);
    (force_of_tip(chain, tip, middle) < force ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace turgor::rhombus
