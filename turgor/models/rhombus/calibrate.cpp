#include "turgor/models/rhombus/calibrate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "turgor/core/number_text.hpp"
#include "turgor/models/rhombus/tip.hpp"

namespace turgor::rhombus {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kAngles[2] = {2 * kDegree, 88 * kDegree}, kDecays[2] = {0.2, 30};
constexpr double kStiffness[2] = {1e-6, 1e6};  // [N/m]
constexpr double kMostDepth = 1;               // [m]
constexpr double kContactForce = 0.1;          // accepted at depth 0, relative to the largest force [1]

using Unknowns = Eigen::Vector4d;  // unbounded: see to_params

/// Maps any number into the interval between two bounds, on a logarithmic scale.
double bounded(double x, const double (&bounds)[2]) {
  const double fraction = 1 / (1 + std::exp(-x));
  return bounds[0] * std::pow(bounds[1] / bounds[0], fraction);
}
double unbounded(double value, const double (&bounds)[2]) {
  const double fraction =
      std::clamp(std::log(value / bounds[0]) / std::log(bounds[1] / bounds[0]), 1e-3, 1 - 1e-3);
  return std::log(fraction / (1 - fraction));
}

ChainParams to_params(const Unknowns& x, const ChainParams& start) {
  ChainParams p = start;
  p.normal = bounded(x[0], kStiffness), p.tangential = bounded(x[1], kStiffness);
  p.decay = bounded(x[2], kDecays), p.angle = bounded(x[3], kAngles);
  return p;
}
Unknowns to_unknowns(const ChainParams& p) {
  return {unbounded(p.normal, kStiffness), unbounded(p.tangential, kStiffness), unbounded(p.decay, kDecays),
          unbounded(p.angle, kAngles)};
}

/// Residual of the fit.
struct Problem {
  std::span<const CurvePoint> curve;
  ChainParams start;
  double peak = 0;  // largest force [N]
  int evaluations = 0;

  /// Chain minus curve, relative to the curve's force.
  Eigen::VectorXd residual(const Unknowns& x) {
    evaluations++;
    const Chain chain = *build_chain(to_params(x, start));
    const Tip tip = tip_on(chain, start.tip);
    Eigen::VectorXd r(Eigen::Index(curve.size()));
    double guess = 0;
    for (std::size_t i = 0; i < curve.size(); i++) {
      guess = chain_force(chain, tip, curve[i].depth, guess);
      const double found = tip_force(chain, tip, curve[i].depth, guess);
      r[Eigen::Index(i)] = (found - curve[i].force) / std::max(std::abs(curve[i].force), kFitFloor * peak);
    }
    return r;
  }
  Eigen::MatrixXd jacobian(const Unknowns& x) {
    Eigen::MatrixXd j(Eigen::Index(curve.size()), 4);
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 4; k++) {
      const Unknowns d = Unknowns::Unit(k) * kStep;
      j.col(k) = (residual(x + d) - residual(x - d)) / (2 * kStep);
    }
    return j;
  }
};

/// Levenberg–Marquardt: damped Gauss–Newton steps, accepted when the sum of squares decreases.
Unknowns minimize(Problem& problem, Unknowns x) {
  Eigen::VectorXd r = problem.residual(x);
  double damping = 1e-2;
  for (int i = 0; i < 100; i++) {
    // normal equations
    const Eigen::MatrixXd j = problem.jacobian(x);
    const Eigen::Matrix4d normal = j.transpose() * j;
    const Unknowns slope = j.transpose() * r;
    bool better = false;
    Unknowns step;
    // increase the damping until a step is an improvement
    for (int tries = 0; tries < 12 && !better; tries++) {
      Eigen::Matrix4d damped = normal;
      damped.diagonal() += damping * (normal.diagonal().array() + 1e-9).matrix();
      step = -damped.ldlt().solve(slope);
      step *= std::min(
          1.0,
          2 / step.cwiseAbs().maxCoeff());  // limits steps towards the interval's ends, which are at infinity
      if (!step.allFinite()) return x;
      const Eigen::VectorXd next = problem.residual(x + step);
      better = next.squaredNorm() < r.squaredNorm();
      damping *= better ? 0.3 : 4;
      if (!better) continue;
      const bool done = r.squaredNorm() - next.squaredNorm() < 1e-10 * r.squaredNorm();
      x += step, r = next;
      if (done) return x;
    }
    if (!better) return x;
  }
  return x;
}

/// Point with the largest force among those with a depth.
const CurvePoint& strongest_point(std::span<const CurvePoint> curve) {
  const auto force = [](const CurvePoint& p) { return p.depth == 0 ? -1 : std::abs(p.force); };
  return *std::max_element(curve.begin(), curve.end(), [&](auto& a, auto& b) { return force(a) < force(b); });
}

/// Error: a point outside the range of chains, or a force against its depth.
Status check_point(const CurvePoint& point) {
  const auto [depth, force] = point;
  if (!std::isfinite(depth) || !std::isfinite(force)) return Error{"a depth or a force is not finite"};
  if (std::abs(depth) > kMostDepth)
    return Error{"expected a depth of at most " + number_text(kMostDepth) + " m, found " +
                 number_text(depth) + " m; a column in mm is named depth_mm"};
  if (std::abs(force) > kMostForce)
    return Error{"expected a force of at most " + number_text(kMostForce) + " N, found " +
                 number_text(force) + " N"};
  if (depth * force < 0)
    return Error{"expected a force that resists, found " + number_text(force) + " N at " +
                 number_text(depth) + " m"};
  return Done{};
}

Status check(std::span<const CurvePoint> curve) {
  // points
  const auto at = [](std::size_t i) { return "point " + std::to_string(i) + " of the force-depth curve: "; };
  int useful = 0;
  for (std::size_t i = 0; i < curve.size(); i++) {
    if (const Status good = check_point(curve[i]); !good) return Error{at(i) + good.error().message};
    useful += curve[i].depth != 0 && curve[i].force != 0;
  }
  if (useful < 4)
    return Error{"the force-depth curve: expected at least 4 points with a depth and a force, found " +
                 std::to_string(useful)};
  // no force before the contact
  const CurvePoint& strongest = strongest_point(curve);
  const double bearable = kContactForce * std::abs(strongest.force);
  for (std::size_t i = 0; i < curve.size(); i++)
    if (curve[i].depth == 0 && std::abs(curve[i].force) > bearable)
      return Error{at(i) + "expected no force at a depth of 0, found " + number_text(curve[i].force) +
                   " N, more than a tenth of the largest force at other depths, " +
                   number_text(std::abs(strongest.force)) + " N"};
  // stiffness
  const double secant = strongest.force / strongest.depth;
  if (!(secant >= kStiffness[0] && secant <= kStiffness[1]))
    return Error{"the force-depth curve: expected a stiffness from " + number_text(kStiffness[0]) + " to " +
                 number_text(kStiffness[1]) + " N/m, found " + number_text(strongest.force) + " N at " +
                 number_text(strongest.depth) + " m"};
  return Done{};
}

}  // namespace

Result<Fit> calibrate(std::span<const CurvePoint> curve, const ChainParams& start) {
  if (const Status good = check(curve); !good) return good.error();
  if (const auto chain = build_chain(start); !chain) return chain.error();
  Problem problem{curve, start};
  // strongest point of the curve, for scaling
  const CurvePoint& strongest = strongest_point(curve);
  problem.peak = std::abs(strongest.force);
  const double secant = strongest.force / strongest.depth;
  Unknowns best;
  double least = std::numeric_limits<double>::infinity();
  // minimize from several starting points
  for (const double angle : {15.0, 45.0, 75.0})
    for (const double decay : {0.7, 2.0, 8.0})
      for (const double ratio : {0.2, 3.0}) {
        ChainParams from = start;
        from.normal = secant, from.tangential = ratio * secant, from.decay = decay,
        from.angle = angle * kDegree;
        // Starting point with the curve's stiffness at its end; all stiffnesses scale alike.
        const Chain chain = *build_chain(from);
        const double force = std::abs(force_of_tip(chain, tip_on(chain, from.tip), strongest.depth));
        from.normal *= problem.peak / force, from.tangential *= problem.peak / force;
        const Unknowns found = minimize(problem, to_unknowns(from));
        const double squares = problem.residual(found).squaredNorm();
        if (squares < least) least = squares, best = found;
      }
  if (!std::isfinite(least))
    return Error{"the force-depth curve: no chain fits it, its residual is not finite"};
  const Eigen::VectorXd r = problem.residual(best);
  return Fit{to_params(best, start), std::sqrt(r.squaredNorm() / double(r.size())), r.cwiseAbs().maxCoeff(),
             problem.evaluations};
}

}  // namespace turgor::rhombus
