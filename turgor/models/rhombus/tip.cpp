#include "turgor/models/rhombus/tip.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::rhombus {

namespace {

// Disc depths in radii of the disc. From kGrows, which is Sneddon's at two radii, the chain grows with the
// disc, so that no chain is deeper than kGrows + kGrowsWithin.
constexpr double kGrows = 1.6104, kGrowsWithin = 0.2;

/// Depth of the chain under a disc of a given depth, both in radii, and its derivative. Its curvature is
/// continuous, so the stiffness of the tip has no step.
struct BoundedDepth {
  double depth = 0, slope = 1;
};
BoundedDepth bounded_depth(double disc) {
  if (disc <= kGrows) return {disc, 1};
  const double beyond = (disc - kGrows) / kGrowsWithin, root = std::sqrt(1 + beyond * beyond);
  return {kGrows + kGrowsWithin * beyond / root, 1 / (root * root * root)};
}

/// True if the chain grows under a disc of this depth [m].
bool grows(const Tip& tip, double disc) { return tip.radius > 0 && disc > kGrows * tip.radius; }

}  // namespace

Tip tip_on(const Chain& chain, double radius) {
  if (chain.params.tip == 0) return {};
  const double pressing = std::max(radius, kSharpestTip), holding = std::max(radius, kSharpestHold);
  return {pressing, pressing / chain.params.tip, holding / chain.params.tip};
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

// A disc on a half space has the energy E* R u². A chain of scale s at the depth x has it for s³ x² = s₀ u²,
// with s₀ the scale of the tip.
double scale_at(const Tip& tip, double depth) {
  if (!(depth > 0)) return tip.hold_scale;
  const double disc = disc_depth(tip, depth).depth;
  if (!grows(tip, disc)) return tip.scale;
  const double radii = disc / tip.radius;
  return tip.scale * std::cbrt(std::pow(radii / bounded_depth(radii).depth, 2));
}

double chain_force(const Chain& chain, const Tip& tip, double depth, double guess) {
  TURGOR_CHECK(tip.scale > 0 && tip.hold_scale > 0, "the scale of a tip is positive");
  if (!(depth > 0)) return force_of_depth(chain, depth / tip.hold_scale, guess);
  const double disc = disc_depth(tip, depth).depth;
  if (!grows(tip, disc)) return force_of_depth(chain, disc / tip.scale, guess);
  return force_of_depth(chain, bounded_depth(disc / tip.radius).depth * chain.params.tip, guess);
}

// The derivative of the energy s³ e(x) by the tip's depth, with x = g(x₀), x₀ = u/s₀ and s³ = s₀³ (x₀/x)²
double tip_force(const Chain& chain, const Tip& tip, double depth, double chain_force) {
  if (!(depth > 0)) return tip.hold_scale * tip.hold_scale * chain_force;
  const DiscDepth disc = disc_depth(tip, depth);
  const double scale2 = tip.scale * tip.scale;
  if (!grows(tip, disc.depth)) return scale2 * chain_force * disc.slope;
  // chain of a larger disc
  const BoundedDepth bounded = bounded_depth(disc.depth / tip.radius);
  const double free = disc.depth / tip.scale, x = bounded.depth * chain.params.tip;
  const double twice_energy = 2 * chain_energy(chain, chain_force), growth = free / x;
  return scale2 * disc.slope * growth *
         (twice_energy / x + growth * bounded.slope * (chain_force - twice_energy / x));
}

double tip_energy(const Chain& chain, const Tip& tip, double depth, double chain_force) {
  const double scale = scale_at(tip, depth);
  return scale * scale * scale * chain_energy(chain, chain_force);
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
