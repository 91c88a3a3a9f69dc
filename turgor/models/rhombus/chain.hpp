// The chain: rhombi in series under a touch, which all carry the same force and become stiffer with distance
// from it [RC eqs. 8-11]. Force follows from depth and depth from force; pressing is positive, pulling
// negative. A unit takes part when it rotates by more than 5 % of θ [RC: λ = Δθ/θ], and moves by the excess.
// So the chain ends without a step, and force, energy and shape are continuous in the depth
// (docs/models/rhombus.md).
#pragma once

#include <array>

#include "turgor/core/assert.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/unit.hpp"

namespace turgor::rhombus {

constexpr int kMaxUnits = 48;
constexpr double kMostForce = 1e6;  // [N]

/// Parameters of a chain. The defaults are the liver of the paper, with sides that give the paper's range on
/// an organ of that size.
struct ChainParams {
  double normal = 1.5;         // k_N of every unit [N/m]
  double tangential = 1.8;     // k_T of the first unit [N/m]
  double decay = 2;            // β: k_T grows by e^(1/β) from unit to unit [1]
  double angle = 0.785398163;  // θ at rest [rad]
  double side = 0.005;         // a [m]
  double boundary = 0.05;      // fraction of θ up to which a unit does not move [1]
  double stiffening = 10;      // largest logarithmic growth of K over a pull by the unit's own height [1]
  double tip =
      0;  // radius of the ball that the parameters describe (tip.hpp); 0: independent of the tool [m]
};

/// State at which a unit starts to move: the first unit at once, the others at `boundary`.
struct UnitStart {
  double force = 0;              // magnitude [N]
  double normal_change = 0;      // [m]
  double tangential_change = 0;  // [m]
  double energy = 0;             // [J]
};

struct Chain {
  ChainParams params;
  std::array<Unit, kMaxUnits> units;
  std::array<UnitStart, kMaxUnits> pressed, pulled;  // forces ascending
  double deepest = 0, highest = 0;  // at kMostForce pressed and pulled, the range of depths [m]
};

/// Builds a chain. Error: θ outside (0, 90°), a stiffness, β, side or stiffening that is not positive, a
/// negative tip, a boundary outside (0, 0.5).
Result<Chain> build_chain(const ChainParams& params);

/// Bound of dK/dF, the growth of any stiffness K of the chain with its force: K ≤ K(0) + bound · F. Units in
/// series grow no faster than the fastest of them [1/m].
double growth_bound(const Chain& chain);

/// Tangential width of a unit at rest: length of one index step of the chain [m].
double unit_width(const Chain& chain);

/// Depth under a force, and its derivative.
struct ChainDepth {
  double depth = 0;       // [m]
  double compliance = 0;  // d depth / d force [m/N]
  int units = 0;          // units that move
};
ChainDepth depth_of_force(const Chain& chain, double force);

/// Force at a depth, monotonic, 0 at 0. Depths beyond Chain::deepest and highest are clamped. `guess`: a
/// force nearby as the starting value. Never fails.
double force_of_depth(const Chain& chain, double depth, double guess = 0);

/// Work done on the chain up to this force [J]: ∫ F d(depth).
double chain_energy(const Chain& chain, double force);

/// Shape of the surface over a chain: values at whole indices s = 0 … units, with C¹ cubic interpolation. Its
/// slope is zero at the axis and at the end.
struct ChainShape {
  int units = 0;
  std::array<double, kMaxUnits + 1> depth{}, depth_slope{};      // along the touch [m], per unit of s
  std::array<double, kMaxUnits + 1> outward{}, outward_slope{};  // away from the axis [m], per unit of s
};
ChainShape shape_of_force(const Chain& chain, double force);

/// Displacement of the surface at the (continuous) index s; zero beyond the last unit.
struct ShapePoint {
  double depth = 0, outward = 0;  // [m]
};
inline ShapePoint shape_at(const ChainShape& shape, double s) {
  if (!(s < shape.units)) return {};
  TURGOR_CHECK(s >= 0, "an index along a chain is not negative");
  const std::size_t j = std::size_t(s) % kMaxUnits;  // the modulo gives GCC the bound
  const double t = s - double(j), u = 1 - t;
  const double from = u * u * (1 + 2 * t), to = t * t * (3 - 2 * t), leave = u * u * t, arrive = -u * t * t;
  return {shape.depth[j] * from + shape.depth[j + 1] * to + shape.depth_slope[j] * leave +
              shape.depth_slope[j + 1] * arrive,
          shape.outward[j] * from + shape.outward[j + 1] * to + shape.outward_slope[j] * leave +
              shape.outward_slope[j + 1] * arrive};
}

}  // namespace turgor::rhombus
