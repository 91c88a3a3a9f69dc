// Contact of a ball with a chain. A chain with ChainParams::tip describes a disc of that radius. Under a tool
// of another radius the chain is scaled as an elastic half space: lengths and stiffnesses with the radius,
// forces with its square.
//
// The contact area of a ball grows with its depth d, that of a disc does not. The chain is therefore at the
// depth u(d) at which a disc has the same energy,
//
//     ½ (2 E* R) u² = ∫ F_Sneddon dd      F = f(u) u'(d)
//
// so that work and energy agree exactly for every chain. A chain with f = 2 E* R u gives the force of
// Sneddon's rigid sphere [Sneddon 1965], at first touch that of Hertz. When pulled, tools hold what they
// touch: u = d. A chain without a tip is that of the paper, which has no tools: every tool meets the chain
// itself.
//
// Units meet their stops soon below a depth of two radii. From there on the chain grows with the depth, to
// that of a larger disc with the same energy. On a half space every such chain gives the same force, so the
// force stays that of Sneddon's sphere, and a sharp tip needs no short chain.
#pragma once

#include "turgor/models/rhombus/chain.hpp"

namespace turgor::rhombus {

/// Smallest effective radius of a tip that presses, and of one that holds. The model is not valid for sharper
/// tips [m].
constexpr double kSharpestTip = 1e-4, kSharpestHold = 5e-4;
/// Largest valid depth of a press, in radii of the tip.
constexpr double kDeepestPress = 6;

/// A ball on a chain.
struct Tip {
  double radius = 0;      // 0: a tool that meets the chain itself [m]
  double scale = 1;       // of the chain's lengths and stiffnesses in a press down to two radii, relative to
                          // its parameters
  double hold_scale = 1;  // likewise, of tissue that is pulled
};
Tip tip_on(const Chain& chain, double radius);

/// Depth u of the disc and its derivative.
struct DiscDepth {
  double depth = 0;  // u [m]
  double slope = 1;  // u'(d)
};
/// Depth of the disc. The resulting force is within 1 % of Sneddon's sphere up to a depth of six radii.
DiscDepth disc_depth(const Tip& tip, double depth);

/// Scale of the chain at a depth of the tip.
double scale_at(const Tip& tip, double depth);

/// Unscaled force of the chain at this depth of the tip: the argument of shape_of_force and chain_energy [N].
double chain_force(const Chain& chain, const Tip& tip, double depth, double guess = 0);

/// Force on the tip [N] and energy [J] for the chain's force at this depth.
double tip_force(const Chain& chain, const Tip& tip, double depth, double chain_force);
double tip_energy(const Chain& chain, const Tip& tip, double depth, double chain_force);
/// Force on the tip at a depth [N].
inline double force_of_tip(const Chain& chain, const Tip& tip, double depth) {
  return tip_force(chain, tip, depth, chain_force(chain, tip, depth));
}

/// Depth of a pressed tip under a force of 0 or more [m].
double depth_of_tip(const Chain& chain, const Tip& tip, double force);

}  // namespace turgor::rhombus
