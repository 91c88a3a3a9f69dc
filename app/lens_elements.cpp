#include "app/lens_elements.hpp"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::VectorXd;
using ElementMatrix = Eigen::Matrix<double, 8, 8>;
using ElementVector = Eigen::Matrix<double, 8, 1>;

/// Distance of a lip from the line between the ends of the lens [m].
double half_width(const LensMembrane& m, double x) {
  const double a = m.length / 2, w = m.width / 2, radius = (a * a + w * w) / (2 * w);
  return x >= a ? 0 : std::sqrt(radius * radius - x * x) - (radius - w);
}

/// Adds lines up to `to`. Their distances grow by a ratio from `first`, at most to `largest`.
void add_growing(std::vector<double>& lines, double to, double first, double largest, double ratio) {
  for (double h = first; lines.back() < to; h = std::min(largest, ratio * h)) {
    const double next = lines.back() + h;
    lines.push_back(next > to - 0.6 * h ? to : next);
  }
}

/// A quarter of the membrane: x along the lens from its middle, s away from its lip. Nodes at s have y = s
/// plus the half width, which fades out far away.
struct LensMesh {
  std::vector<double> x, s;
  std::vector<Vector2d> rest;
  std::vector<char> held;  // by node and axis

  LensMesh(const LensMembrane& m, int divisions) {
    const double h = m.length / 2 / divisions, end = m.length / 2;
    // from the end of the lens inward, and outward
    std::vector<double> inward{0};
    add_growing(inward, end, 0.2 * h, h, 1.3);
    for (std::size_t n = inward.size(); n-- > 0;) x.push_back(end - inward[n]);
    add_growing(x, m.side / 2, 0.2 * h, m.side, 1.15);
    // lines at the bite
    const int within = std::max(2, int(std::lround(m.bite / h)));
    for (int n = 0; n <= within; n++) s.push_back(m.bite * n / within);
    add_growing(s, m.bite + 6 * h, h, h, 1);
    add_growing(s, m.side / 2, h, m.side, 1.12);
    // nodes
    const double near = 2 * m.bite + 6 * h;
    for (const double t : s)
      for (const double at : x) {
        const double fade = t < near ? 1 : (m.side / 2 - t) / (m.side / 2 - near);
        rest.emplace_back(at, t + fade * half_width(m, at));
        const bool is_side = at == x.back() || t == s.back();
        held.push_back(is_side || at == 0), held.push_back(is_side || (t == 0 && at >= end));
      }
  }
  int node(std::size_t i, std::size_t j) const { return int(i + x.size() * j); }
};

/// Stitch: the weighted displacement of nodes across the lens.
struct LensStitch {
  std::vector<std::pair<int, double>> weights;  // by node
  double goal = 0;                              // [m]
};

std::vector<LensStitch> stitches_of(const LensMembrane& m, const LensMesh& mesh) {
  const auto width_at = [](const std::vector<double>& lines, std::size_t i) {
    return (i > 0 ? lines[i] - lines[i - 1] : 0) + (i + 1 < lines.size() ? lines[i + 1] - lines[i] : 0);
  };
  const auto hat = [&](double distance) { return std::max(0.0, 1 - std::abs(distance) / m.patch); };
  std::vector<LensStitch> stitches;
  for (int n = 0; n < m.stitches / 2; n++) {
    const double at = (n + 0.5) * m.length / m.stitches;
    LensStitch stitch{.weights = {}, .goal = -half_width(m, at)};
    double sum = 0;
    for (std::size_t j = 0; j < mesh.s.size(); j++)
      for (std::size_t i = 0; i < mesh.x.size(); i++) {
        // with the mirror image of the patch at the symmetry axis
        const double along = hat(mesh.x[i] - at) + (i > 0 ? hat(mesh.x[i] + at) : 0);
        const double weight =
            along * hat(mesh.s[j] - m.bite) * width_at(mesh.x, i) * (i == 0 ? 2 : 1) * width_at(mesh.s, j);
        if (weight > 0) stitch.weights.emplace_back(mesh.node(i, j), weight), sum += weight;
      }
    for (auto& [node, weight] : stitch.weights) weight /= sum;
    stitches.push_back(std::move(stitch));
  }
  return stitches;
}

struct LensSystem {
  VectorXd gradient;
  std::vector<Eigen::Triplet<double>> second;
  double force = 0;  // of the stitches [N]

  void add(int row, int column, double value) { second.emplace_back(row, column, value); }
};

/// Adds fibers with the energy ½ K (|g| − r)² per area, g = F eₐ, r = 1 − T/K.
void add_fiber(const LensMembrane& m, Vector2d g, const std::array<double, 4>& slope, double area,
               ElementVector& gradient, ElementMatrix& second) {
  const double length = g.norm(), pull = area * m.stiffness * (length - (1 - m.tension / m.stiffness));
  const Matrix2d along = g * g.transpose() / (length * length);
  const Matrix2d k = area * m.stiffness * along + pull / length * (Matrix2d::Identity() - along);
  for (int a = 0; a < 4; a++) {
    gradient.segment<2>(2 * a) += g * (pull / length * slope[std::size_t(a)]);
    for (int b = 0; b < 4; b++)
      second.block<2, 2>(2 * a, 2 * b) += k * (slope[std::size_t(a)] * slope[std::size_t(b)]);
  }
}

/// Adds shear with the energy ½ G (g₁·g₂)² per area.
void add_shear(const LensMembrane& m, const Matrix2d& f, const std::array<Vector2d, 4>& slope, double area,
               ElementVector& gradient, ElementMatrix& second) {
  const double sheared = f.col(0).dot(f.col(1)), k = area * m.stiffness / 2;
  std::array<Vector2d, 4> first;
  for (std::size_t a = 0; a < 4; a++) first[a] = f.col(0) * slope[a][1] + f.col(1) * slope[a][0];
  for (int a = 0; a < 4; a++) {
    const Vector2d u = first[std::size_t(a)], s = slope[std::size_t(a)];
    gradient.segment<2>(2 * a) += k * sheared * u;
    for (int b = 0; b < 4; b++) {
      const Vector2d v = first[std::size_t(b)], t = slope[std::size_t(b)];
      second.block<2, 2>(2 * a, 2 * b) +=
          k * (u * v.transpose() + sheared * (s[0] * t[1] + s[1] * t[0]) * Matrix2d::Identity());
    }
  }
}

/// Adds an element with four quadrature points.
void add_element(const LensMembrane& m, const LensMesh& mesh, const VectorXd& u,
                 const std::array<int, 4>& nodes, LensSystem& system) {
  ElementVector gradient = ElementVector::Zero();
  ElementMatrix second = ElementMatrix::Zero();
  const double near = 0.5 - 0.5 / std::sqrt(3.0);
  for (int point = 0; point < 4; point++) {
    const double s = point & 1 ? 1 - near : near, t = point >> 1 ? 1 - near : near;
    // gradients of the shape functions at rest
    std::array<Vector2d, 4> slope;
    Matrix2d jacobian = Matrix2d::Zero(), f = Matrix2d::Zero();
    for (std::size_t c = 0; c < 4; c++) {
      slope[c] = {(c & 1 ? 1 : -1) * (c >> 1 ? t : 1 - t), (c >> 1 ? 1 : -1) * (c & 1 ? s : 1 - s)};
      jacobian += mesh.rest[std::size_t(nodes[c])] * slope[c].transpose();
    }
    const Matrix2d to_rest = jacobian.inverse().transpose();
    for (std::size_t c = 0; c < 4; c++) {
      slope[c] = to_rest * slope[c];
      f += (mesh.rest[std::size_t(nodes[c])] + u.segment<2>(2 * nodes[c])) * slope[c].transpose();
    }
    // energies
    const double area = jacobian.determinant() / 4;
    for (int axis = 0; axis < 2; axis++)
      add_fiber(m, f.col(axis), {slope[0][axis], slope[1][axis], slope[2][axis], slope[3][axis]}, area,
                gradient, second);
    add_shear(m, f, slope, area, gradient, second);
  }
  // free unknowns
  const auto unknown = [&](int a) { return 2 * nodes[std::size_t(a / 2)] + a % 2; };
  for (int a = 0; a < 8; a++) {
    if (mesh.held[std::size_t(unknown(a))]) continue;
    system.gradient[unknown(a)] += gradient[a];
    for (int b = 0; b < 8; b++)
      if (!mesh.held[std::size_t(unknown(b))]) system.add(unknown(a), unknown(b), second(a, b));
  }
}

/// Elements, and stitches as stiff springs to this share of their goals.
LensSystem assemble(const LensMembrane& m, const LensMesh& mesh, const std::vector<LensStitch>& stitches,
                    double share, const VectorXd& u) {
  LensSystem system{.gradient = VectorXd::Zero(u.size()), .second = {}};
  for (std::size_t j = 0; j + 1 < mesh.s.size(); j++)
    for (std::size_t i = 0; i + 1 < mesh.x.size(); i++)
      add_element(m, mesh, u,
                  {mesh.node(i, j), mesh.node(i + 1, j), mesh.node(i, j + 1), mesh.node(i + 1, j + 1)},
                  system);
  for (const LensStitch& stitch : stitches) {
    double apart = -share * stitch.goal;
    for (const auto& [node, weight] : stitch.weights) apart += weight * u[2 * node + 1];
    const double spring = apart > 0 || m.pushes ? 3000 * m.stiffness : 0;
    system.force += spring * apart;
    for (const auto& [node, weight] : stitch.weights) {
      if (mesh.held[std::size_t(2 * node + 1)]) continue;
      system.gradient[2 * node + 1] += spring * apart * weight;
      for (const auto& [other, weight_there] : stitch.weights)
        if (!mesh.held[std::size_t(2 * other + 1)])
          system.add(2 * node + 1, 2 * other + 1, spring * weight * weight_there);
    }
  }
  for (int n = 0; n < int(u.size()); n++)
    if (mesh.held[std::size_t(n)]) system.add(n, n, 1);
  return system;
}

}  // namespace

double closing_force_of_elements(const LensMembrane& membrane, int divisions) {
  TURGOR_ASSERT(membrane.stitches > 0 && membrane.stitches % 2 == 0, "half of the stitches are in a quarter");
  constexpr int kLoadSteps = 8, kMostIterations = 30;
  const LensMesh mesh(membrane, divisions);
  const std::vector<LensStitch> stitches = stitches_of(membrane, mesh);
  VectorXd u = VectorXd::Zero(2 * Eigen::Index(mesh.rest.size()));
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  Eigen::SparseMatrix<double> matrix(u.size(), u.size());
  double force = 0;
  for (int load = 1; load <= kLoadSteps; load++) {
    bool has_converged = false;
    for (int iteration = 0; iteration < kMostIterations && !has_converged; iteration++) {
      const LensSystem system = assemble(membrane, mesh, stitches, double(load) / kLoadSteps, u);
      matrix.setFromTriplets(system.second.begin(), system.second.end());
      if (load == 1 && iteration == 0) solver.analyzePattern(matrix);
      solver.factorize(matrix);
      const VectorXd step = solver.solve(system.gradient);
      u -= step;
      force = 2 * system.force;  // of both halves
      has_converged = iteration > 0 && step.norm() < 1e-8 * u.norm();
    }
    if (!has_converged) return std::numeric_limits<double>::quiet_NaN();
  }
  return force;
}

}  // namespace turgor
