// A ball pressed into a layer that is bonded to its base, by an independent finite-strain program:
// axisymmetric quadrilaterals with eight nodes, contact by a penalty on the deformed surface without
// friction, and tangents by differences of the stress. Ψ = µ/2b (exp(b (Ī₁ − 3)) − 1) + κ/2 (J − 1)².
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <vector>

namespace turgor {

enum class PressedLaw : std::uint8_t {
  kExponential,  // Ψ = µ/2b (exp(b (Ī₁ − 3)) − 1) + κ/2 (J − 1)²
  kStable,       // stable Neo-Hookean [Smith, de Goes and Kim 2018]
  kLinear        // small strain; only the contact follows the displacements
};

/// A ball of other tissue on the axis; none if its radius is 0.
struct Nodule {
  double depth = 0, radius = 0;  // of its center below the surface at rest [m]
  double young = 0;              // [Pa]
};

struct PressedLayer {
  double thickness = 0.02, width = 0.07;  // [m]
  double ball = 0.03;                     // radius [m]
  double young = 4e3, poisson = 0.45;     // [Pa], [1]
  double stiffening = 0;                  // b [1]
  PressedLaw law = PressedLaw::kExponential;
  Nodule nodule;
  int across = 18, down = 8;  // elements
  double step = 5e-4;         // of the depth, between solutions [m]
  double softness = 5e-6;     // penetration at a pressure of Young's modulus [m]
};

class AxisymmetricPress {
 public:
  explicit AxisymmetricPress(const PressedLayer& layer) : layer_(layer) {
    shear_ = layer.young / (2 * (1 + layer.poisson)), bulk_ = layer.young / (3 * (1 - 2 * layer.poisson));
    make_mesh();
    u_ = Eigen::VectorXd::Zero(2 * Eigen::Index(x_.size()));
  }

  /// Force on the ball at this depth of its tip [N], from the present solution in steps.
  double force(double depth) {
    while (depth_ < depth) solve_at(depth_ = std::min(depth, depth_ + layer_.step));
    return contact_force_;
  }

 private:
  void solve_at(double depth) {
    center_ = layer_.ball - depth;
    for (const double softness : {1e-4, layer_.softness}) solve_with(layer_.young / softness);
  }
  void solve_with(double penalty) {
    penalty_ = penalty;
    assemble();
    for (int i = 0; i < 60; i++) {
      const double size = residual_.norm();
      if (i > 0 && size < 1e-8 * layer_.young * layer_.ball * layer_.ball) break;
      Eigen::SparseMatrix<double> k(u_.size(), u_.size());
      k.setFromTriplets(entries_.begin(), entries_.end());
      Eigen::SparseLU<Eigen::SparseMatrix<double>> factor(k);
      const Eigen::VectorXd step = factor.solve(residual_), start = u_;
      for (double length = 1; length > 0.01; length /= 2) {
        u_ = start - length * step;
        assemble();
        if (residual_.norm() < size) break;  // false for NaN
      }
    }
  }

  using Matrix3 = Eigen::Matrix3d;
  static constexpr double kPi = 3.14159265358979323846;

  Matrix3 stress(const Matrix3& f) const {
    if (layer_.law == PressedLaw::kLinear) {
      const Matrix3 strain = 0.5 * (f + f.transpose()) - Matrix3::Identity();
      return 2 * shear_ * strain + (bulk_ - 2.0 / 3 * shear_) * strain.trace() * Matrix3::Identity();
    }
    if (layer_.law == PressedLaw::kStable) {
      // µ' and λ' that are linear elasticity at rest
      const double mu = 4.0 / 3 * shear_, lambda = bulk_ - 2.0 / 3 * shear_ + 5.0 / 6 * shear_,
                   volume = f.determinant(), rest = 1 + 0.75 * mu / lambda;
      const Matrix3 cofactor = volume * f.inverse().transpose();
      return mu * (1 - 1 / (f.squaredNorm() + 1)) * f + lambda * (volume - rest) * cofactor;
    }
    const double j = f.determinant(), r = std::pow(j, -2.0 / 3), i1 = (f.transpose() * f).trace();
    const Matrix3 inverse = f.inverse().transpose();
    const double c = shear_ * std::exp(layer_.stiffening * (r * i1 - 3));
    return c * r * (f - i1 / 3 * inverse) + bulk_ * (j - 1) * j * inverse;
  }

  /// Planes that are dense at the axis and at the surface.
  void make_mesh() {
    const int nr = 2 * layer_.across, nz = 2 * layer_.down;
    std::vector<std::vector<int>> number(std::size_t(nr + 1), std::vector<int>(std::size_t(nz + 1), -1));
    const auto r_at = [&](double s) { return layer_.width * (0.25 * s + 0.75 * s * s * s); };
    const auto z_at = [&](double s) { return -layer_.thickness * (0.5 * s + 0.5 * s * s); };
    for (int i = 0; i <= nr; i++)
      for (int k = 0; k <= nz; k++)
        if (i % 2 == 0 || k % 2 == 0) {
          number[std::size_t(i)][std::size_t(k)] = int(x_.size());
          const auto middle = [](int n, int all, auto at) {
            return n % 2 == 0 ? at(double(n) / all)
                              : 0.5 * (at(double(n - 1) / all) + at(double(n + 1) / all));
          };
          x_.push_back({middle(i, nr, r_at), middle(k, nz, z_at)});
          held_.push_back({i == 0 || k == nz, k == nz});
        }
    for (int i = 0; i < nr; i += 2)
      for (int k = 0; k < nz; k += 2) {
        const auto at = [&](int a, int b) { return number[std::size_t(i + a)][std::size_t(k + b)]; };
        elements_.push_back({at(0, 2), at(2, 2), at(2, 0), at(0, 0), at(1, 2), at(2, 1), at(1, 0), at(0, 1)});
        if (k == 0) top_.push_back({at(0, 0), at(1, 0), at(2, 0)});
      }
  }

  void assemble() {
    residual_ = Eigen::VectorXd::Zero(u_.size());
    entries_.clear();
    for (const auto& element : elements_) add_element(element);
    contact_force_ = 0;
    for (const auto& edge : top_) add_contact(edge);
    for (std::size_t n = 0; n < x_.size(); n++)
      for (int c = 0; c < 2; c++)
        if (held_[n][std::size_t(c)]) {
          const auto row = int(2 * n) + c;
          residual_[row] = 0;
          entries_.emplace_back(row, row, 1e9);
        }
  }
  void add(int row, int column, double value) {
    const auto is_held = [&](int k) { return held_[std::size_t(k / 2)][std::size_t(k % 2)]; };
    if (!is_held(row) && !is_held(column)) entries_.emplace_back(row, column, value);
  }

  /// Serendipity functions and slopes.
  static void functions(double s, double t, std::array<double, 8>& n, std::array<double, 8>& ds,
                        std::array<double, 8>& dt) {
    constexpr double kS[] = {-1, 1, 1, -1, 0, 1, 0, -1}, kT[] = {-1, -1, 1, 1, -1, 0, 1, 0};
    for (std::size_t a = 0; a < 8; a++) {
      const double p = kS[a], q = kT[a];
      if (a < 4) {
        n[a] = 0.25 * (1 + p * s) * (1 + q * t) * (p * s + q * t - 1);
        ds[a] = 0.25 * p * (1 + q * t) * (2 * p * s + q * t);
        dt[a] = 0.25 * q * (1 + p * s) * (p * s + 2 * q * t);
      } else if (p == 0) {
        n[a] = 0.5 * (1 - s * s) * (1 + q * t), ds[a] = -s * (1 + q * t), dt[a] = 0.5 * q * (1 - s * s);
      } else {
        n[a] = 0.5 * (1 + p * s) * (1 - t * t), ds[a] = 0.5 * p * (1 - t * t), dt[a] = -t * (1 + p * s);
      }
    }
  }

  void add_element(const std::array<int, 8>& nodes) {
    constexpr double kG = 0.577350269189626;
    for (const double s : {-kG, kG})
      for (const double t : {-kG, kG}) {
        std::array<double, 8> n, ds, dt;
        functions(s, t, n, ds, dt);
        Eigen::Matrix2d map = Eigen::Matrix2d::Zero();
        double radius = 0, height = 0, ur = 0;
        for (std::size_t a = 0; a < 8; a++) {
          const auto& x = x_[std::size_t(nodes[a])];
          map(0, 0) += ds[a] * x[0], map(0, 1) += ds[a] * x[1];
          map(1, 0) += dt[a] * x[0], map(1, 1) += dt[a] * x[1];
          radius += n[a] * x[0], height += n[a] * x[1], ur += n[a] * u_[2 * nodes[a]];
        }
        const bool is_nodule = std::hypot(radius, height + layer_.nodule.depth) < layer_.nodule.radius;
        const double modulus = is_nodule ? layer_.nodule.young / layer_.young : 1;
        const double weight = 2 * kPi * radius * map.determinant();
        // b: derivative of (F_rr, F_rz, F_zr, F_zz, F_θθ) by the displacements
        Eigen::Matrix<double, 5, 16> b = Eigen::Matrix<double, 5, 16>::Zero();
        const Eigen::Matrix2d back = map.inverse();
        for (std::size_t a = 0; a < 8; a++) {
          const double dr = back(0, 0) * ds[a] + back(0, 1) * dt[a],
                       dz = back(1, 0) * ds[a] + back(1, 1) * dt[a];
          const auto c = Eigen::Index(2 * a);
          b(0, c) = dr, b(1, c) = dz, b(2, c + 1) = dr, b(3, c + 1) = dz, b(4, c) = n[a] / radius;
        }
        Eigen::Matrix<double, 16, 1> u;
        for (std::size_t a = 0; a < 8; a++)
          u[Eigen::Index(2 * a)] = u_[2 * nodes[a]], u[Eigen::Index(2 * a + 1)] = u_[2 * nodes[a] + 1];
        const Eigen::Matrix<double, 5, 1> f = b * u;
        const auto stress_of = [&](const Eigen::Matrix<double, 5, 1>& g) {
          Matrix3 full = Matrix3::Identity();
          full(0, 0) += g[0], full(0, 1) += g[1], full(1, 0) += g[2], full(1, 1) += g[3], full(2, 2) += g[4];
          const Matrix3 p = modulus * stress(full);
          return Eigen::Matrix<double, 5, 1>(p(0, 0), p(0, 1), p(1, 0), p(1, 1), p(2, 2));
        };
        const Eigen::Matrix<double, 5, 1> p = stress_of(f);
        Eigen::Matrix<double, 5, 5> slope;
        constexpr double kStep = 1e-6;
        for (int c = 0; c < 5; c++) {
          Eigen::Matrix<double, 5, 1> up = f, down = f;
          up[c] += kStep, down[c] -= kStep;
          slope.col(c) = (stress_of(up) - stress_of(down)) / (2 * kStep);
        }
        const Eigen::Matrix<double, 16, 1> force = weight * b.transpose() * p;
        const Eigen::Matrix<double, 16, 16> k = weight * b.transpose() * slope * b;
        const auto row = [&](int i) { return 2 * nodes[std::size_t(i / 2)] + i % 2; };
        for (int i = 0; i < 16; i++) {
          residual_[row(i)] += force[i];
          for (int j = 0; j < 16; j++) add(row(i), row(j), k(i, j));
        }
      }
  }

  /// Penalty ∫ ½ e ⟨−g⟩² dA on the surface at rest, g = |x − c| − R.
  void add_contact(const std::array<int, 3>& edge) {
    const double e = penalty_;
    for (const double s : {-0.861136311594053, -0.339981043584856, 0.339981043584856, 0.861136311594053}) {
      const double w = std::abs(s) > 0.5 ? 0.347854845137454 : 0.652145154862546;
      const std::array<double, 3> n{0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)};
      const std::array<double, 3> dn{s - 0.5, -2 * s, s + 0.5};
      double r = 0, z = 0, radius = 0, length = 0;
      for (std::size_t a = 0; a < 3; a++) {
        const auto& x = x_[std::size_t(edge[a])];
        r += n[a] * (x[0] + u_[2 * edge[a]]), z += n[a] * (x[1] + u_[2 * edge[a] + 1]);
        radius += n[a] * x[0], length += dn[a] * x[0];
      }
      const double far = std::hypot(r, z - center_), gap = far - layer_.ball;
      if (gap >= 0) continue;
      const double weight = w * length * 2 * kPi * radius;
      const Eigen::Vector2d normal(r / far, (z - center_) / far);
      const Eigen::Matrix2d outer = normal * normal.transpose();
      const Eigen::Matrix2d k = weight * e * (outer + gap / far * (Eigen::Matrix2d::Identity() - outer));
      contact_force_ += weight * e * gap * normal[1];
      for (std::size_t a = 0; a < 3; a++)
        for (int i = 0; i < 2; i++) {
          residual_[2 * edge[a] + i] += weight * e * gap * normal[i] * n[a];
          for (std::size_t b = 0; b < 3; b++)
            for (int j = 0; j < 2; j++) add(2 * edge[a] + i, 2 * edge[b] + j, n[a] * n[b] * k(i, j));
        }
    }
  }

  PressedLayer layer_;
  double shear_ = 0, bulk_ = 0, center_ = 0, contact_force_ = 0, depth_ = 0, penalty_ = 0;
  std::vector<std::array<double, 2>> x_;
  std::vector<std::array<bool, 2>> held_;
  std::vector<std::array<int, 8>> elements_;
  std::vector<std::array<int, 3>> top_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::VectorXd u_, residual_;
};

}  // namespace turgor
