// Porcine skin under biaxial stretch (Tac et al. 2022). Laws at a point of the material, fitted to the
// equibiaxial curve and to the strip along x, predict the strip along y. The fiber law is the one of
// lattices; the exponential one is that of Gasser, Ogden and Holzapfel for an incompressible membrane.
#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "app/least_squares.hpp"
#include "app/measured_table.hpp"

namespace turgor {

namespace {

constexpr const char* kSkinSource = "Tac et al. 2022";

struct BiaxialPoint {
  double stretch[2], stress[2];  // Cauchy [kPa]
};
// quoted points of the published curves
constexpr BiaxialPoint kEquibiaxial[] = {
    {{1, 1}, {0.4547, 1.154}},          {{1.0108, 1.0106}, {-0.4597, 0.2692}},
    {{1.0229, 1.0228}, {5.117, 5.721}}, {{1.0337, 1.0333}, {7.051, 11.38}},
    {{1.0448, 1.0445}, {20.24, 22.72}}, {{1.0557, 1.0555}, {32.84, 51.36}},
    {{1.0683, 1.0681}, {59.27, 95.03}}, {{1.0795, 1.0793}, {93.08, 152.2}},
    {{1.0911, 1.0909}, {139.3, 226.2}}, {{1.1026, 1.1023}, {192.5, 313.5}},
    {{1.1157, 1.1156}, {275.4, 449.3}}, {{1.1275, 1.1276}, {364.9, 603.7}}};
constexpr BiaxialPoint kStripX[] = {
    {{1, 1}, {0.456, 1.167}},      {{1.0186, 1}, {1.393, 0.2692}}, {{1.037, 1}, {-0.4729, 0.2692}},
    {{1.0557, 1}, {4.333, 2.962}}, {{1.075, 1}, {7.353, 6.552}},   {{1.0944, 1}, {15.37, 13.82}},
    {{1.1165, 1}, {31.87, 21.99}}, {{1.1366, 1}, {60.23, 36.53}},  {{1.1572, 1}, {103.2, 58.25}},
    {{1.1782, 1}, {172.2, 82.75}}, {{1.1995, 1}, {269.8, 118.9}},  {{1.2215, 1}, {412.8, 167}}};
constexpr BiaxialPoint kStripY[] = {
    {{1, 1}, {2.263, -0.6247}},    {{1, 1.0124}, {1.358, 0.2711}}, {{1, 1.0263}, {4.074, 4.855}},
    {{1, 1.0391}, {4.979, 9.645}}, {{1, 1.0535}, {12.13, 23.04}},  {{1, 1.066}, {17.56, 42.53}},
    {{1, 1.0813}, {28.34, 85.02}}, {{1, 1.0942}, {40.01, 128.4}},  {{1, 1.1095}, {57.03, 206.2}},
    {{1, 1.1232}, {76.86, 300.8}}, {{1, 1.1389}, {106.5, 445.7}},  {{1, 1.1524}, {135.2, 608.7}}};

/// Cauchy stress of the columns of a law, for each stretch along x and y.
using Columns = std::vector<std::vector<double>>;

/// Exponential law, for unit µ and k1; k2, κ and the fibers' angle to x enter nonlinearly.
///   W = µ/2 (I₁ − 3) + k1/(2 k2) (exp(k2 E²) − 1),  E = κ (I₁ − 3) + (1 − 3κ)(I₄ − 1) > 0
///   I₁ = λx² + λy² + 1/(λx λy)²,  I₄ = λx² cos²θ + λy² sin²θ,  σᵢ = λᵢ ∂W/∂λᵢ
Columns exponential_columns(const std::vector<double>& x, std::span<const BiaxialPoint> points) {
  const double k2 = std::exp(x[0]), kappa = 1 / (3 * (1 + std::exp(-x[1]))), c = std::cos(x[2]);
  Columns columns(2);
  for (const BiaxialPoint& p : points)
    for (int axis = 0; axis < 2; axis++) {
      const double a = p.stretch[0] * p.stretch[0], b = p.stretch[1] * p.stretch[1], across = 1 / (a * b);
      const double own = p.stretch[axis] * p.stretch[axis], share = axis == 0 ? c * c : 1 - c * c;
      const double first = a + b + across - 3, fourth = a * c * c + b * (1 - c * c) - 1;
      const double e = std::max(0.0, kappa * first + (1 - 3 * kappa) * fourth);
      const double d_first = 2 * (own - across), d_fourth = 2 * own * share;  // λ ∂/∂λ
      columns[0].push_back(d_first / 2);
      columns[1].push_back(e * std::exp(std::min(80.0, k2 * e * e)) *
                           (kappa * d_first + (1 - 3 * kappa) * d_fourth));
    }
  return columns;
}

/// Fiber law of lattices, for unit K and K β: σᵢ = λᵢ s (1 + β s), s = λᵢ − 1 > 0. Fibers do not act on each
/// other.
Columns fiber_columns(std::span<const BiaxialPoint> points) {
  Columns columns(2);
  for (const BiaxialPoint& p : points)
    for (const double stretch : p.stretch) {
      const double s = std::max(0.0, stretch - 1);
      columns[0].push_back(stretch * s);
      columns[1].push_back(stretch * s * s);
    }
  return columns;
}

std::vector<double> stresses(std::span<const BiaxialPoint> points) {
  std::vector<double> list;
  for (const BiaxialPoint& p : points) list.insert(list.end(), {p.stress[0], p.stress[1]});
  return list;
}

std::vector<double> combined(const Columns& columns, const std::vector<double>& coefficients) {
  std::vector<double> sum(columns[0].size(), 0);
  for (std::size_t j = 0; j < columns.size(); j++)
    for (std::size_t n = 0; n < sum.size(); n++) sum[n] += coefficients[j] * columns[j][n];
  return sum;
}

std::vector<BiaxialPoint> fitted_points() {
  std::vector<BiaxialPoint> points(std::begin(kEquibiaxial), std::end(kEquibiaxial));
  points.insert(points.end(), std::begin(kStripX), std::end(kStripX));
  return points;
}

std::vector<double> predict_exponential() {
  const std::vector<BiaxialPoint> points = fitted_points();
  const std::vector<double> measured = stresses(points);
  const auto error = [&](const std::vector<double>& x) {
    return fit_non_negative(exponential_columns(x, points), measured).squared_error;
  };
  // the best of three starts: fibers along x, oblique, along y
  std::vector<double> best;
  for (const double angle : {0.2, 0.8, 1.4}) {
    const std::vector<double> found = minimize(error, {2, 0, angle}, 0.5, 400);
    if (best.empty() || error(found) < error(best)) best = found;
  }
  return combined(exponential_columns(best, kStripY),
                  fit_non_negative(exponential_columns(best, points), measured).coefficients);
}

std::vector<double> predict_fiber() {
  const std::vector<BiaxialPoint> points = fitted_points();
  return combined(fiber_columns(kStripY),
                  fit_non_negative(fiber_columns(points), stresses(points)).coefficients);
}

/// Rows and curves of both stresses of the strip along y; bands of 10 % of the largest stress.
void add_law(const char* law, const std::vector<double>& predicted, MeasuredResult& result) {
  const std::vector<double> measured = stresses(kStripY);
  const double largest = *std::max_element(measured.begin(), measured.end());
  for (int axis = 0; axis < 2; axis++) {
    MeasuredCurve curve{
        fmt::format("skin-{}-{}.svg", axis == 0 ? "x" : "y", law),
        fmt::format("Skin stretched along y, stress along {}, {} law", axis == 0 ? "x" : "y", law),
        "stretch along y",
        "stress [kPa]",
        {}};
    for (std::size_t n = 0; n < std::size(kStripY); n++) {
      const std::size_t at = 2 * n + std::size_t(axis);
      curve.points.push_back({kStripY[n].stretch[1], measured[at], 0.1 * largest, predicted[at]});
    }
    const auto& last = curve.points.back();
    result.rows.push_back(band_row(
        fmt::format("skin strip along y, {} law: stress along {} at the end", law, axis == 0 ? "x" : "y"),
        kSkinSource, "kPa", last.measured, last.half, last.predicted));
    result.curves.push_back(std::move(curve));
  }
}

}  // namespace

void add_skin_sheet(MeasuredResult& result) {
  add_law("fiber", predict_fiber(), result);
  add_law("exponential", predict_exponential(), result);
}

}  // namespace turgor
