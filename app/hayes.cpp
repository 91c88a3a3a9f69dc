#include "app/hayes.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace turgor {

namespace {

constexpr double kPi = std::numbers::pi;

/// Displacement of the layer under a harmonic pressure, relative to a half space [1]; x waves in 2π
/// thicknesses.
double sinking(double x, double poisson) {
  const double k = 3 - 4 * poisson, e = std::exp(-2 * x);  // hyperbolic functions, times 2 exp(−2x)
  return (k * (1 - e * e) - 4 * x * e) / (k * (1 + e * e) + (4 * x * x + 1 + k * k) * e);
}

/// ∫ (1 − sinking(x)) cos(u x) dx from 0 to ∞, by Simpson's rule; the integrand vanishes beyond x = 20.
double kernel(double u, double poisson) {
  constexpr int kSteps = 1000;
  constexpr double kStep = 20.0 / kSteps;
  double sum = 0;
  for (int i = 0; i <= kSteps; i++) {
    const double weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * (1 - sinking(i * kStep, poisson)) * std::cos(u * i * kStep);
  }
  return sum * kStep / 3;
}

/// Gauss–Legendre points and weights on [0, 1], from the eigenvectors of Legendre's recurrence (Golub and
/// Welsch).
struct GaussRule {
  Eigen::VectorXd point, weight;
};
GaussRule gauss_rule(int points) {
  Eigen::MatrixXd recurrence = Eigen::MatrixXd::Zero(points, points);
  for (int i = 1; i < points; i++)
    recurrence(i, i - 1) = recurrence(i - 1, i) = i / std::sqrt(4.0 * i * i - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> found(recurrence);
  return {(found.eigenvalues().array() + 1) / 2, found.eigenvectors().row(0).transpose().array().square()};
}

/// Pressure as φ at the Gauss points and at the edge of the contact. Its Hankel transform is ∫ φ(t) cos(ξt)
/// dt.
struct Pressure {
  double total = 0;  // [N]
  double edge = 0;   // φ(a) [N/m]; zero where the pressure ends without a step
};

/// Solves φ(x) − 1/π ∫ φ(t) (K(x−t) + K(x+t)) dt = G/(1−ν) ψ(x), where the shape of the indenter gives ψ.
template <class Shape>
Pressure solve(const BondedLayer& layer, double radius, const Shape& shape) {
  constexpr int kPoints = 24;
  const double poisson = layer.material.poisson, h = layer.thickness;
  const double modulus = layer.material.young / (2 * (1 + poisson)) / (1 - poisson);
  const GaussRule rule = gauss_rule(kPoints);
  const auto coupling = [&](double x, int j) {
    const double t = radius * rule.point[j];
    return radius * rule.weight[j] * (kernel((x - t) / h, poisson) + kernel((x + t) / h, poisson)) /
           (kPi * h);
  };
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(kPoints, kPoints);
  Eigen::VectorXd right(kPoints);
  for (int i = 0; i < kPoints; i++) {
    const double x = radius * rule.point[i];
    for (int j = 0; j < kPoints; j++) system(i, j) -= coupling(x, j);
    right[i] = modulus * shape(x);
  }
  const Eigen::VectorXd phi = system.partialPivLu().solve(right);
  Pressure pressure{2 * kPi * radius * rule.weight.dot(phi), modulus * shape(radius)};
  for (int j = 0; j < kPoints; j++) pressure.edge += coupling(radius, j) * phi[j];
  return pressure;
}

}  // namespace

Indentation hayes_punch(const BondedLayer& layer, double radius, double depth) {
  return {depth, solve(layer, radius, [&](double) { return 2 / kPi * depth; }).total};
}

Indentation hayes_sphere(const BondedLayer& layer, double sphere_radius, double contact_radius) {
  // The force is linear in the depth. The depth follows from a pressure that ends without a step.
  const auto ball = [&](double x) { return -2 / kPi * x * std::atanh(x / sphere_radius); };
  const Pressure flat = solve(layer, contact_radius, [](double) { return 2 / kPi; }),
                 round = solve(layer, contact_radius, ball);
  const double depth = -round.edge / flat.edge;
  return {depth, round.total + depth * flat.total};
}

}  // namespace turgor
