#include "app/curved_wound.hpp"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace turgor {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Lines from 0 to `to`, denser at the end, or at the start.
std::vector<double> graded(double from, double to, int count, bool dense_at_end) {
  std::vector<double> lines;
  for (int n = 1; n <= count; n++) {
    const double t = double(n) / count;
    lines.push_back(from + (to - from) * (dense_at_end ? 1 - std::pow(1 - t, 1.6) : std::pow(t, 1.6)));
  }
  return lines;
}
std::vector<double> joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
/// The lines, mirrored at 0.
std::vector<double> mirrored(const std::vector<double>& positive) {
  std::vector<double> lines;
  for (auto it = positive.rbegin(); it != positive.rend(); ++it) lines.push_back(-*it);
  lines.push_back(0);
  return joined(lines, positive);
}

/// A grid over (s, t, depth), where the blade lies at t = 0. Nodes on the blade are doubled.
class Mesh {
 public:
  std::array<std::vector<double>, 3> lines;  // s, t and depth [m]
  std::vector<Vector3d> x;                   // positions of nodes, copies after the others
  std::vector<char> held;
  std::vector<int> copy;  // node on the side t > 0, by node; the node itself where it is not doubled
  int middle = 0;         // index of t = 0

  Mesh(const CurvedWound& wound, int divisions) {
    // denser at the ends of the blade, its edge and the skin
    lines[0] = mirrored(joined(graded(0, wound.half_length, divisions, true),
                               graded(wound.half_length, wound.half_x, divisions, false)));
    lines[1] = mirrored(graded(0, wound.half_y, divisions + divisions / 2, false));
    lines[2] = {0};
    for (int n = 1, count = divisions * 3 / 4; n <= count; n++)
      lines[2].push_back(wound.depth * 0.5 * (1 - std::cos(std::numbers::pi * n / count)));
    lines[2] = joined(lines[2], graded(wound.depth, wound.thickness, std::max(2, divisions / 2), false));
    middle = size(1) / 2;

    // nodes
    for (int k = 0; k < size(2); k++)
      for (int j = 0; j < size(1); j++)
        for (int i = 0; i < size(0); i++) {
          const double s = lines[0][std::size_t(i)], t = lines[1][std::size_t(j)];
          const double fade = 1 - std::abs(t) / wound.half_y, y = t + wound.curve(s) * fade * fade;
          x.emplace_back(s, y, wound.height(s, y) - lines[2][std::size_t(k)]);
          held.push_back(i == 0 || j == 0 || i + 1 == size(0) || j + 1 == size(1) || k + 1 == size(2));
          copy.push_back(int(copy.size()));
        }
    // copies
    constexpr double kSlack = 1e-9;
    for (int k = 0; k < size(2); k++)
      for (int i = 0; i < size(0); i++)
        if (std::abs(lines[0][std::size_t(i)]) < wound.half_length - kSlack &&
            lines[2][std::size_t(k)] < wound.depth - kSlack) {
          copy[std::size_t(node(i, middle, k))] = int(x.size());
          x.push_back(x[std::size_t(node(i, middle, k))]), held.push_back(0);
        }
  }
  int size(int axis) const { return int(lines[std::size_t(axis)].size()); }
  int node(int i, int j, int k) const { return i + size(0) * (j + size(1) * k); }
  /// Node of an element whose lowest t has index j.
  int node_of(int i, int j, int k, int element_j) const {
    const int n = node(i, j, k);
    return element_j >= middle ? copy[std::size_t(n)] : n;
  }
};

/// Stiffness of a mesh.
class Stiffness {
 public:
  explicit Stiffness(const Mesh& mesh) : mesh_(mesh) {}

  void add(int row, int column, const Matrix3d& block) {
    if (mesh_.held[std::size_t(row)] || mesh_.held[std::size_t(column)]) return;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) terms_.emplace_back(3 * row + a, 3 * column + b, block(a, b));
  }
  Matrix matrix() {
    for (int n = 0; n < int(mesh_.x.size()); n++)
      if (mesh_.held[std::size_t(n)])
        for (int a = 0; a < 3; a++) terms_.emplace_back(3 * n + a, 3 * n + a, 1.0);
    const auto count = Index(3 * mesh_.x.size());
    Matrix k(count, count);
    k.setFromTriplets(terms_.begin(), terms_.end());
    return k;
  }

 private:
  const Mesh& mesh_;
  std::vector<Eigen::Triplet<double>> terms_;
};

constexpr double kGauss = 0.57735026918962576;

/// Adds a hexahedron: eight points for shear, the mean gradients for the change of volume.
void add_hexahedron(const CurvedWound& wound, const Mesh& mesh, const std::array<int, 8>& node,
                    Stiffness& stiffness) {
  const double mu = wound.young / (2 * (1 + wound.poisson)),
               bulk = wound.young / (3 * (1 - 2 * wound.poisson));
  std::array<std::array<Vector3d, 8>, 8> gradient;
  std::array<double, 8> weight{};
  std::array<Vector3d, 8> mean;
  mean.fill(Vector3d::Zero());
  double volume = 0;
  for (std::size_t p = 0; p < 8; p++) {
    const Vector3d at{p & 1 ? kGauss : -kGauss, p & 2 ? kGauss : -kGauss, p & 4 ? kGauss : -kGauss};
    std::array<Vector3d, 8> slope;
    Matrix3d jacobian = Matrix3d::Zero();
    for (std::size_t n = 0; n < 8; n++) {
      const Vector3d sign{n & 1 ? 1.0 : -1.0, n & 2 ? 1.0 : -1.0, n & 4 ? 1.0 : -1.0};
      const Vector3d term = Vector3d::Ones() + sign.cwiseProduct(at);
      slope[n] =
          Vector3d{sign[0] * term[1] * term[2], term[0] * sign[1] * term[2], term[0] * term[1] * sign[2]} / 8;
      jacobian += mesh.x[std::size_t(node[n])] * slope[n].transpose();
    }
    weight[p] = std::abs(jacobian.determinant());
    const Matrix3d inverse = jacobian.inverse().transpose();
    for (std::size_t n = 0; n < 8; n++)
      gradient[p][n] = inverse * slope[n], mean[n] += weight[p] * gradient[p][n];
    volume += weight[p];
  }
  for (std::size_t a = 0; a < 8; a++)
    for (std::size_t b = 0; b < 8; b++) {
      // 2µ dev ε : dev ε, and κ (tr ε)² with the mean of tr ε
      Matrix3d block = bulk / volume * mean[a] * mean[b].transpose();
      for (std::size_t p = 0; p < 8; p++) {
        const Vector3d &g = gradient[p][a], &h = gradient[p][b];
        block += weight[p] * mu *
                 (g.dot(h) * Matrix3d::Identity() + h * g.transpose() - 2.0 / 3 * g * h.transpose());
      }
      stiffness.add(node[a], node[b], block);
    }
}

/// Adds a quadrilateral of skin. Second variation of fibers with stiffness K under tension T, and of shear G:
/// ½ K (a · ∂ₐu)² + ½ T |∂ₐu − a (a · ∂ₐu)|², likewise across, and ½ G (a · ∂_b u + b · ∂ₐu)².
void add_skin(const CurvedWound& wound, const Mesh& mesh, const std::array<int, 4>& node,
              Stiffness& stiffness) {
  for (int p = 0; p < 4; p++) {
    // tangents and their dual vectors
    const double s = p & 1 ? kGauss : -kGauss, t = p & 2 ? kGauss : -kGauss;
    std::array<Vector2d, 4> slope;
    Vector3d g1 = Vector3d::Zero(), g2 = Vector3d::Zero();
    for (std::size_t n = 0; n < 4; n++) {
      const double ss = n & 1 ? 1 : -1, st = n & 2 ? 1 : -1;
      slope[n] = {ss * (1 + st * t) / 4, st * (1 + ss * s) / 4};
      g1 += slope[n][0] * mesh.x[std::size_t(node[n])], g2 += slope[n][1] * mesh.x[std::size_t(node[n])];
    }
    Vector3d normal = g1.cross(g2);
    const double area = normal.norm();
    normal /= area;
    const Vector3d dual1 = g2.cross(normal) / area, dual2 = normal.cross(g1) / area;
    // fibers along the projection of x, and across
    const Vector3d a = (Vector3d::UnitX() - normal * normal[0]).normalized(), b = normal.cross(a);
    std::array<double, 4> da{}, db{};
    for (std::size_t n = 0; n < 4; n++) {
      const Vector3d g = slope[n][0] * dual1 + slope[n][1] * dual2;
      da[n] = a.dot(g), db[n] = b.dot(g);
    }
    const Matrix3d aa = a * a.transpose(), bb = b * b.transpose(), one = Matrix3d::Identity();
    const Matrix3d along = wound.stiffness * aa + wound.tension * (one - aa),
                   across = wound.stiffness * bb + wound.tension * (one - bb);
    for (std::size_t m = 0; m < 4; m++)
      for (std::size_t n = 0; n < 4; n++) {
        const Vector3d shear_m = a * db[m] + b * da[m], shear_n = a * db[n] + b * da[n];
        stiffness.add(node[m], node[n],
                      area * (along * da[m] * da[n] + across * db[m] * db[n] +
                              wound.shear * shear_m * shear_n.transpose()));
      }
  }
}

Matrix stiffness_of(const CurvedWound& wound, const Mesh& mesh) {
  Stiffness stiffness(mesh);
  for (int k = 0; k + 1 < mesh.size(2); k++)
    for (int j = 0; j + 1 < mesh.size(1); j++)
      for (int i = 0; i + 1 < mesh.size(0); i++) {
        std::array<int, 8> node{};
        for (int c = 0; c < 8; c++)
          node[std::size_t(c)] = mesh.node_of(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2), j);
        add_hexahedron(wound, mesh, node, stiffness);
        if (k == 0) add_skin(wound, mesh, {node[0], node[1], node[2], node[3]}, stiffness);
      }
  return stiffness.matrix();
}

/// Direction across the blade, on the skin, from t < 0 to t > 0, between two nodes of a lip.
Vector3d across_lip(const CurvedWound& wound, const Vector3d& from, const Vector3d& to) {
  const Vector3d middle = 0.5 * (from + to);
  constexpr double kStep = 1e-6;
  const double dx =
                   (wound.height(middle[0] + kStep, middle[1]) - wound.height(middle[0] - kStep, middle[1])) /
                   (2 * kStep),
               dy =
                   (wound.height(middle[0], middle[1] + kStep) - wound.height(middle[0], middle[1] - kStep)) /
                   (2 * kStep);
  return Vector3d{-dx, -dy, 1}.cross(to - from).normalized();
}

}  // namespace

Gape gape_of_linear_elements(const CurvedWound& wound, int divisions) {
  const Mesh mesh(wound, divisions);
  // the tension that the lips lose pulls them apart
  VectorXd force = VectorXd::Zero(Index(3 * mesh.x.size()));
  for (int i = 0; i + 1 < mesh.size(0); i++) {
    if (std::abs(0.5 * (mesh.lines[0][std::size_t(i)] + mesh.lines[0][std::size_t(i + 1)])) >
        wound.half_length)
      continue;
    const int ends[2] = {mesh.node(i, mesh.middle, 0), mesh.node(i + 1, mesh.middle, 0)};
    const Vector3d from = mesh.x[std::size_t(ends[0])], to = mesh.x[std::size_t(ends[1])];
    const Vector3d pull = 0.5 * wound.tension * (to - from).norm() * across_lip(wound, from, to);
    for (const int n : ends) {
      force.segment<3>(3 * n) -= pull;
      force.segment<3>(3 * Index(mesh.copy[std::size_t(n)])) += pull;
    }
  }
  // displacements
  const Matrix k = stiffness_of(wound, mesh);
  Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper> solver(k);
  solver.setTolerance(1e-8);
  const VectorXd u = solver.solve(force);
  // distances of the lips
  Gape gape;
  for (int i = 1; i + 1 < mesh.size(0); i++) {
    const int n = mesh.node(i, mesh.middle, 0), other = mesh.copy[std::size_t(n)];
    if (other == n) continue;
    const Vector3d across = across_lip(wound, mesh.x[std::size_t(mesh.node(i - 1, mesh.middle, 0))],
                                       mesh.x[std::size_t(mesh.node(i + 1, mesh.middle, 0))]);
    const double open = (u.segment<3>(3 * Index(other)) - u.segment<3>(3 * n)).dot(across);
    gape.largest = std::max(gape.largest, open);
    if (2 * i + 1 == mesh.size(0)) gape.middle = open;
  }
  return gape;
}

Gape limit_of_linear_elements(const CurvedWound& wound, int coarse, int fine) {
  const Gape a = gape_of_linear_elements(wound, coarse), b = gape_of_linear_elements(wound, fine);
  const double more = double(coarse) / (fine - coarse);
  return {b.largest + (b.largest - a.largest) * more, b.middle + (b.middle - a.middle) * more};
}

}  // namespace turgor
