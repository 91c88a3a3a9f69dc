// What a ball makes of a chain. A chain with ChainParams::tip is that of a disc of this radius; under a tool
// of another one it is larger or smaller as a whole, as an elastic half space is: lengths and stiffnesses
// go with the radius, so forces with its square.
//
// A ball does not touch like a disc: what it touches grows as it goes in. Pressed by d, it feels the chain
// as if it turned a gear: the chain is at the depth u(d) where a disc would have stored as much energy,
//
//     ½ (2 E* R) u² = ∫ F_Sneddon dd      F = f(u) u'(d)
//
// so work and energy agree to the last bit whatever the chain, and a chain with f = 2 E* R u answers like
// Sneddon's rigid sphere [Sneddon 1965], at first touch like Hertz. Pulled, tools hold what they touch: u =
// d. A chain without a tip is the paper's, which knows no tools: every one feels the chain itself.
#pragma once

#include "turgor/models/rhombus/chain.hpp"

namespace turgor::rhombus {

/// A sharper tip than this is felt as a ball of this radius: what it does to tissue is not known here [m].
constexpr double kSharpestTip = 5e-4;

/// A ball on a chain.
struct Tip {
  double radius = 0;  // 0: a tool that feels the chain itself [m]
  double scale = 1;   // of the chain: its lengths and stiffnesses, in multiples of what it was built with
};
Tip tip_on(const Chain& chain, double radius);

/// The depth u of the disc, and how fast it goes with the ball's.
struct DiscDepth {
  double depth = 0;  // u [m]
  double slope = 1;  // u'(d)
};
/// Within 1 % of the force of Sneddon's sphere up to a depth of six radii.
DiscDepth disc_depth(const Tip& tip, double depth);

/// Force of the chain, unscaled, when the tip is this deep: what shape_of_force and chain_energy take [N].
double chain_force(const Chain& chain, const Tip& tip, double depth, double guess = 0);

/// Force on the tip [N] and energy [J] that belong to it.
inline double tip_force(const Tip& tip, double depth, double chain_force) {
  return tip.scale * tip.scale * chain_force * disc_depth(tip, depth).slope;
}
inline double tip_energy(const Chain& chain, const Tip& tip, double chain_force) {
  return tip.scale * tip.scale * tip.scale * chain_energy(chain, chain_force);
}
/// As above, in one.
inline double force_of_tip(const Chain& chain, const Tip& tip, double depth) {
  return tip_force(tip, depth, chain_force(chain, tip, depth));
}

/// How deep a pressed tip is under a force of 0 or more [m].
double depth_of_tip(const Chain& chain, const Tip& tip, double force);

}  // namespace turgor::rhombus
