#include "turgor/models/rhombus/chain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"

namespace turgor::rhombus {

namespace {

Status check(const ChainParams& p) {
  // angle
  if (!(p.angle > 0 && p.angle < std::numbers::pi / 2))
    return Error{"the angle of the rhombi: expected more than 0 and less than 90 degrees, found " +
                 number_text(p.angle * 180 / std::numbers::pi)};
  // positive parameters
  const std::pair<const char*, double> positive[] = {{"normal stiffness k_N [N/m]", p.normal},
                                                     {"tangential stiffness k_T [N/m]", p.tangential},
                                                     {"decay beta", p.decay},
                                                     {"side a [m]", p.side},
                                                     {"stiffening", p.stiffening}};
  for (const auto& [name, value] : positive)
    if (!(value > 0 && std::isfinite(value)))
      return Error{std::string(name) + " of the rhombi: expected a number above 0, found " +
                   number_text(value)};
  // tip and boundary
  if (!(p.tip >= 0 && std::isfinite(p.tip)))
    return Error{"the tip radius of the chain [m]: expected 0 or more, found " + number_text(p.tip)};
  if (!(p.boundary > 0 && p.boundary < 0.5))
    return Error{"the boundary of the chain: expected a fraction between 0 and 0.5, found " +
                 number_text(p.boundary)};
  return Done{};
}

UnitStart unit_start(const Unit& unit, double turn) {
  const double force = unit_force(unit, turn);
  const TurnedUnit turned = turn_by_force(unit, force);
  return {std::abs(force), turned.normal_change, turned.tangential_change,
          energy_of_changes(unit, turned.normal_change, turned.tangential_change)};
}

const std::array<UnitStart, kMaxUnits>& unit_starts(const Chain& chain, double force) {
  return force > 0 ? chain.pressed : chain.pulled;
}

/// Calls visit(index, start, state) for every unit that moves under a force. Returns their number.
template <class Visit>
int visit_moving(const Chain& chain, double force, const Visit& visit) {
  TURGOR_CHECK(force != 0, "units move under a force only");
  const double size = std::abs(force);
  const auto& start = unit_starts(chain, force);
  int i = 0;
  for (; i < kMaxUnits && size > start[std::size_t(i)].force; i++)
    visit(i, start[std::size_t(i)], turn_by_force(chain.units[std::size_t(i)], -force));
  return i;
}

/// Slopes for monotonic cubic interpolation. [Fritsch, Butland 1984]
void set_slopes(int units, const std::array<double, kMaxUnits + 1>& value,
                std::array<double, kMaxUnits + 1>& slope) {
  for (int j = 1; j < units; j++) {
    const auto k = std::size_t(j);
    const double before = value[k] - value[k - 1], after = value[k + 1] - value[k];
    slope[k] = before * after > 0 ? 2 * before * after / (before + after) : 0;
  }
}

/// Fraction of the outward displacement that avoids folding: outward points must not pass points farther out,
/// inward points must not pass the axis.
double unfolded_fraction(const Chain& chain, const ChainShape& shape) {
  double largest = 0;
  for (int j = 0; j < shape.units; j++) {
    const auto k = std::size_t(j);
    largest = std::max(largest, std::abs(shape.outward[k + 1] - shape.outward[k]));
  }
  const double bound =
      unit_width(chain) / 3;  // a cubic segment is at most 1.5 times as steep as the line between its ends
  return largest > bound ? bound / largest : 1;
}

}  // namespace

double unit_width(const Chain& chain) { return rest_width(chain.units[0]); }

Result<Chain> build_chain(const ChainParams& params) {
  if (const Status good = check(params); !good) return good.error();
  Chain chain{.params = params};
  // rotation at which units start to move when pulled
  const double pull_turn =
      std::min(params.boundary * params.angle, 0.5 * (std::numbers::pi / 2 - params.angle));
  // units of growing stiffness
  for (int i = 0; i < kMaxUnits; i++) {
    const auto k = std::size_t(i);
    // A stiffer unit is rigid. The bound keeps values finite for very small β.
    const double growth = std::exp(std::min(i / params.decay, 60.0));
    chain.units[k] =
        make_unit(params.side, params.angle, params.normal, params.tangential * growth, params.stiffening);
    if (i > 0) chain.pressed[k] = unit_start(chain.units[k], -params.boundary * params.angle);
    if (i > 0) chain.pulled[k] = unit_start(chain.units[k], pull_turn);
  }
  // range of depths
  chain.deepest = depth_of_force(chain, kMostForce).depth;
  chain.highest = -depth_of_force(chain, -kMostForce).depth;
  TURGOR_CHECK(
      is_ascending(chain.pressed, &UnitStart::force) && is_ascending(chain.pulled, &UnitStart::force),
      "units start to move in the order of the chain");
  return chain;
}

double growth_bound(const Chain& chain) {
  const Unit& unit = chain.units[0];  // all units have the same sides and angle
  return 1 / std::min(unit.pressed.rise, unit.pulled.rise);
}

ChainDepth depth_of_force(const Chain& chain, double force) {
  if (force == 0) return {0, 1 / turn_by_force(chain.units[0], 0).stiffness, 0};
  ChainDepth sum;
  sum.units = visit_moving(chain, force, [&](int, const UnitStart& start, const TurnedUnit& unit) {
    sum.depth -= unit.normal_change - start.normal_change;
    sum.compliance += 1 / unit.stiffness;
  });
  return sum;
}

double force_of_depth(const Chain& chain, double depth, double guess) {
  if (!(depth != 0)) return 0;
  TURGOR_CHECK(std::isfinite(depth), "the depth of a chain is finite");
  const double sign = depth > 0 ? 1 : -1;
  const double goal = std::min(std::abs(depth), depth > 0 ? chain.deepest : chain.highest);
  const double precision = 1e-14 * chain.params.side;
  // bracket and starting value
  double low = 0, high = std::numeric_limits<double>::infinity();
  double force = guess * sign;
  if (!(force > 0 && std::isfinite(force))) force = goal / depth_of_force(chain, 0).compliance;
  for (int i = 0; i < 200; i++) {
    const ChainDepth at = depth_of_force(chain, sign * force);
    const double residual = goal - sign * at.depth;
    if (std::abs(residual) <= precision) break;
    (residual > 0 ? low : high) = force;
    // Newton's step, in the force's logarithm when it is short: past their stops, units are exponential.
    const double growth = residual / (at.compliance * force);
    double next = growth < 1 ? force * std::exp(growth) : force + residual / at.compliance;
    // Newton's steps may alternate where units yield. Every fourth step is a bisection.
    const bool bounded = std::isfinite(high);
    if (!(next > low && next < high) || (bounded && i % 4 == 3))
      next = bounded ? 0.5 * (low + high) : 2 * low;
    if (next == force) break;
    force = next;
  }
  return sign * force;
}

double chain_energy(const Chain& chain, double force) {
  if (force == 0) return 0;
  double sum = 0;
  visit_moving(chain, force, [&](int i, const UnitStart& start, const TurnedUnit& turned) {
    sum += energy_of_changes(chain.units[std::size_t(i)], turned.normal_change, turned.tangential_change) -
           start.energy;
  });
  return sum;
}

ChainShape shape_of_force(const Chain& chain, double force) {
  ChainShape shape;
  if (force == 0) return shape;
  // displacement of each unit
  shape.units = visit_moving(chain, force, [&](int i, const UnitStart& start, const TurnedUnit& unit) {
    shape.depth[std::size_t(i)] = start.normal_change - unit.normal_change;  // of this unit alone at first
    shape.outward[std::size_t(i)] = 0.5 * (unit.tangential_change - start.tangential_change);
  });
  // sum from the end to the axis
  for (int i = shape.units - 1; i >= 0; i--) {
    shape.depth[std::size_t(i)] += shape.depth[std::size_t(i) + 1];
    shape.outward[std::size_t(i)] += shape.outward[std::size_t(i) + 1];
  }
  shape.outward[0] = 0;  // the touch holds the axis
  // avoid folding, then slopes
  TURGOR_CHECK(shape.units <= kMaxUnits, "at most all units of a chain move");
  const double fraction = unfolded_fraction(chain, shape);
  for (double& outward : shape.outward) outward *= fraction;
  set_slopes(shape.units, shape.depth, shape.depth_slope);
  set_slopes(shape.units, shape.outward, shape.outward_slope);
  return shape;
}

}  // namespace turgor::rhombus
