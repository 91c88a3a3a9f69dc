#include "app/wound_elements.hpp"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace turgor {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Adds `count` intervals from the last line to `to`, denser towards one end (`dense` −1 or 1) or both (0).
void add_lines(std::vector<double>& lines, double to, int count, int dense) {
  const double from = lines.back();
  for (int n = 1; n <= count; n++) {
    const double t = double(n) / count;
    const double s = dense < 0   ? std::pow(t, 1.6)
                     : dense > 0 ? 1 - std::pow(1 - t, 1.6)
                                 : 0.5 * (1 - std::cos(std::numbers::pi * t));
    lines.push_back(from + (to - from) * s);
  }
}

/// A quarter of the block: x along the cut from its middle, y across it, z up. The blade lies at y = 0; uncut
/// nodes of this plane stay in it by symmetry.
struct Quarter {
  std::array<std::vector<double>, 3> lines;
  std::vector<int> unknown;  // by node and axis, -1 = held
  int unknowns = 0;

  Quarter(const CutBlock& b, int divisions) {
    for (auto& l : lines) l = {0};
    add_lines(lines[0], b.length / 2, divisions, 1);
    add_lines(lines[0], b.side / 2, divisions, -1);
    add_lines(lines[1], b.side / 2, divisions + divisions / 2, -1);
    add_lines(lines[2], b.height - b.depth, divisions / 2, 1);
    add_lines(lines[2], b.height, divisions * 3 / 4, 0);
    unknown.assign(std::size_t(count() * 3), -1);
    for (int n = 0; n < count(); n++)
      for (int axis = 0; axis < 3; axis++)
        if (!is_held(b, position(n), axis)) unknown[std::size_t(3 * n + axis)] = unknowns++;
  }
  static bool is_held(const CutBlock& b, Vector3d x, int axis) {
    constexpr double kSlack = 1e-9;
    const double half = b.side / 2 - kSlack;
    if (x[0] > half || x[1] > half || x[2] < kSlack) return true;
    const bool is_cut = x[0] < b.length / 2 - kSlack && x[2] > b.height - b.depth + kSlack;
    return (axis == 0 && x[0] < kSlack) || (axis == 1 && x[1] < kSlack && !is_cut);
  }
  int size(int axis) const { return int(lines[std::size_t(axis)].size()); }
  int count() const { return size(0) * size(1) * size(2); }
  int node(int i, int j, int k) const { return i + size(0) * (j + size(1) * k); }
  Vector3d position(int n) const {
    return {lines[0][std::size_t(n % size(0))], lines[1][std::size_t(n / size(0) % size(1))],
            lines[2][std::size_t(n / size(0) / size(1))]};
  }
};

/// Stable Neo-Hookean tissue [Smith, de Goes and Kim 2018] with the term λ' (J − 1)² separate.
struct Tissue {
  double shear, bulk;  // µ', λ' [Pa]
  explicit Tissue(const CutBlock& b) {
    const double mu = b.young / (2 * (1 + b.poisson)),
                 lambda = b.young * b.poisson / ((1 + b.poisson) * (1 - 2 * b.poisson));
    shear = 4.0 / 3 * mu, bulk = lambda + 5.0 / 6 * mu;
  }
};

Matrix3d cofactor(const Matrix3d& f) {
  Matrix3d c;
  c << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
  return c;
}
Matrix3d cross_of(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

/// Energy, gradient and Hessian of one element.
struct Element {
  double energy = 0;
  VectorXd gradient;
  MatrixXd second;
  explicit Element(int nodes)
      : gradient(VectorXd::Zero(3 * nodes)), second(MatrixXd::Zero(3 * nodes, 3 * nodes)) {}
};

/// Adds a term f(J) at a point to an element: `first` is f', `second` is f'', `g` are the gradients of the
/// shape functions.
void add_volume(Element& e, const std::array<Vector3d, 8>& g, const Matrix3d& f, double first,
                double second) {
  const Matrix3d c = cofactor(f);
  for (int a = 0; a < 8; a++) {
    const Vector3d ca = c * g[std::size_t(a)];
    e.gradient.segment<3>(3 * a) += first * ca;
    for (int b = 0; b < 8; b++) {
      const Vector3d cb = c * g[std::size_t(b)];
      // ∂²J/∂x_a∂x_b = −[F (g_a × g_b)]ₓ
      const Vector3d turned = f * g[std::size_t(a)].cross(g[std::size_t(b)]);
      e.second.block<3, 3>(3 * a, 3 * b) += second * ca * cb.transpose() - first * cross_of(turned);
    }
  }
}

/// A brick of tissue: eight points for the shear term, the center for the volume term.
Element brick(const Tissue& tissue, Vector3d size, const std::array<Vector3d, 8>& x) {
  Element e(8);
  const double volume = size.prod();
  const auto at = [&](Vector3d point, std::array<Vector3d, 8>& g, Matrix3d& f) {
    f.setZero();
    for (int c = 0; c < 8; c++) {
      Vector3d weight, slope;
      for (int axis = 0; axis < 3; axis++) {
        const bool up = c >> axis & 1;
        weight[axis] = up ? point[axis] : 1 - point[axis];
        slope[axis] = (up ? 1 : -1) / size[axis];
      }
      g[std::size_t(c)] = {slope[0] * weight[1] * weight[2], weight[0] * slope[1] * weight[2],
                           weight[0] * weight[1] * slope[2]};
      f += x[std::size_t(c)] * g[std::size_t(c)].transpose();
    }
  };
  std::array<Vector3d, 8> g;
  Matrix3d f;
  for (int point = 0; point < 8; point++) {
    const double near = 0.5 - 0.5 / std::sqrt(3.0);
    at({point & 1 ? 1 - near : near, point >> 1 & 1 ? 1 - near : near, point >> 2 ? 1 - near : near}, g, f);
    const double square = f.squaredNorm(), w = volume / 8 * tissue.shear;
    e.energy += w * (0.5 * (square - 3 - std::log((square + 1) / 4)) - 0.75 * (f.determinant() - 1));
    const double first = w * (1 - 1 / (square + 1)), second = 2 * w / ((square + 1) * (square + 1));
    for (int a = 0; a < 8; a++) {
      const Vector3d fa = f * g[std::size_t(a)];
      e.gradient.segment<3>(3 * a) += first * fa;
      for (int b = 0; b < 8; b++) {
        const Vector3d fb = f * g[std::size_t(b)];
        e.second.block<3, 3>(3 * a, 3 * b) +=
            first * g[std::size_t(a)].dot(g[std::size_t(b)]) * Matrix3d::Identity() +
            second * fa * fb.transpose();
      }
    }
    add_volume(e, g, f, -0.75 * w, 0);
  }
  at({0.5, 0.5, 0.5}, g, f);
  const double growth = f.determinant() - 1, k = volume * tissue.bulk;
  e.energy += 0.5 * k * growth * growth;
  add_volume(e, g, f, k * growth, k);
  return e;
}

/// Stretch at which fibers are at rest whose tension is T at stretch 1, by bisection.
double rest_stretch(const CutBlock& b) {
  double low = 0.3, high = 1;
  for (int n = 0; n < 60; n++) {
    const double r = 0.5 * (low + high);
    (b.stiffness * (1 - r) * (1 + b.amplification * (1 - r) / r) > b.tension ? low : high) = r;
  }
  return 0.5 * (low + high);
}

/// A rectangle of skin with four quadrature points.
Element patch(const CutBlock& b, Vector2d size, const std::array<Vector3d, 4>& x) {
  Element e(4);
  const double rest = rest_stretch(b);
  for (int point = 0; point < 4; point++) {
    const double near = 0.5 - 0.5 / std::sqrt(3.0), area = size.prod() / 4;
    const double s = point & 1 ? 1 - near : near, t = point >> 1 ? 1 - near : near;
    std::array<Vector2d, 4> c;
    std::array<Vector3d, 2> fiber = {Vector3d::Zero(), Vector3d::Zero()};
    for (int n = 0; n < 4; n++) {
      c[std::size_t(n)] = {(n & 1 ? 1 : -1) / size[0] * (n >> 1 ? t : 1 - t),
                           (n >> 1 ? 1 : -1) / size[1] * (n & 1 ? s : 1 - s)};
      for (int axis = 0; axis < 2; axis++)
        fiber[std::size_t(axis)] += x[std::size_t(n)] * c[std::size_t(n)][axis];
    }
    for (int axis = 0; axis < 2; axis++) {
      const Vector3d g = fiber[std::size_t(axis)];
      const double length = g.norm(), strain = length - rest, more = strain > 0 ? b.amplification / rest : 0;
      e.energy += area * b.stiffness * strain * strain * (0.5 + more * strain / 3);
      const double pull = area * b.stiffness * strain * (1 + more * strain),
                   stiff = area * b.stiffness * (1 + 2 * more * strain);
      const Matrix3d projector = g * g.transpose() / (length * length),
                     second = stiff * projector + pull / length * (Matrix3d::Identity() - projector);
      for (int a = 0; a < 4; a++) {
        e.gradient.segment<3>(3 * a) += g * (pull / length * c[std::size_t(a)][axis]);
        for (int d = 0; d < 4; d++)
          e.second.block<3, 3>(3 * a, 3 * d) += second * (c[std::size_t(a)][axis] * c[std::size_t(d)][axis]);
      }
    }
    const double sheared = fiber[0].dot(fiber[1]), k = area * b.shear;
    e.energy += 0.5 * k * sheared * sheared;
    std::array<Vector3d, 4> slope;
    for (int a = 0; a < 4; a++) {
      slope[std::size_t(a)] = fiber[0] * c[std::size_t(a)][1] + fiber[1] * c[std::size_t(a)][0];
      e.gradient.segment<3>(3 * a) += k * sheared * slope[std::size_t(a)];
    }
    for (int a = 0; a < 4; a++)
      for (int d = 0; d < 4; d++)
        e.second.block<3, 3>(3 * a, 3 * d) +=
            k * slope[std::size_t(a)] * slope[std::size_t(d)].transpose() +
            k * sheared *
                (c[std::size_t(a)][0] * c[std::size_t(d)][1] + c[std::size_t(a)][1] * c[std::size_t(d)][0]) *
                Matrix3d::Identity();
  }
  return e;
}

struct System {
  double energy = 0;
  VectorXd gradient;
  std::vector<Eigen::Triplet<double>> second;
};

template <std::size_t kNodes>
void add(const Quarter& q, const Element& e, const std::array<int, kNodes>& nodes, System& s) {
  s.energy += e.energy;
  const auto unknown = [&](int n) { return q.unknown[std::size_t(3 * nodes[std::size_t(n / 3)] + n % 3)]; };
  for (int a = 0; a < int(3 * kNodes); a++) {
    const int row = unknown(a);
    if (row < 0) continue;
    s.gradient[row] += e.gradient[a];
    for (int b = 0; b < int(3 * kNodes); b++)
      if (const int column = unknown(b); column >= 0) s.second.emplace_back(row, column, e.second(a, b));
  }
}

System assemble(const CutBlock& block, const Quarter& q, const std::vector<Vector3d>& x) {
  System s;
  s.gradient = VectorXd::Zero(q.unknowns);
  const Tissue tissue(block);
  for (int k = 0; k < q.size(2); k++)
    for (int j = 0; j + 1 < q.size(1); j++)
      for (int i = 0; i + 1 < q.size(0); i++) {
        const bool top = k + 1 == q.size(2);
        std::array<int, 8> nodes{};
        std::array<Vector3d, 8> at;
        for (int c = 0; c < (top ? 4 : 8); c++) {
          nodes[std::size_t(c)] = q.node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
          at[std::size_t(c)] = x[std::size_t(nodes[std::size_t(c)])];
        }
        const Vector3d size = q.position(q.node(i + 1, j + 1, top ? k : k + 1)) - q.position(nodes[0]);
        if (top)
          add<4>(q, patch(block, size.head<2>(), {at[0], at[1], at[2], at[3]}),
                 {nodes[0], nodes[1], nodes[2], nodes[3]}, s);
        else
          add<8>(q, brick(tissue, size, at), nodes, s);
      }
  return s;
}

std::vector<Vector3d> moved(const Quarter& q, const std::vector<Vector3d>& x, const VectorXd& direction,
                            double fraction) {
  std::vector<Vector3d> to = x;
  for (std::size_t n = 0; n < q.unknown.size(); n++)
    if (q.unknown[n] >= 0) to[n / 3][int(n % 3)] += fraction * direction[q.unknown[n]];
  return to;
}

}  // namespace

double gape_of_elements(const CutBlock& block, int divisions) {
  const Quarter q(block, divisions);
  std::vector<Vector3d> x;
  for (int n = 0; n < q.count(); n++) x.push_back(q.position(n));
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  Eigen::SparseMatrix<double> matrix(q.unknowns, q.unknowns);
  double first = 0;
  for (int iteration = 0; iteration < 40; iteration++) {
    const System s = assemble(block, q, x);
    if (iteration == 0) first = s.gradient.norm();
    if (s.gradient.norm() < 1e-7 * first) break;
    matrix.setFromTriplets(s.second.begin(), s.second.end());
    if (iteration == 0) solver.analyzePattern(matrix);
    solver.factorize(matrix);
    VectorXd direction = -solver.solve(s.gradient);
    if (direction.dot(s.gradient) > 0) direction = -s.gradient * (direction.norm() / s.gradient.norm());
    double fraction = 1;
    std::vector<Vector3d> next = moved(q, x, direction, fraction);
    while (fraction > 1e-4 &&
           assemble(block, q, next).energy > s.energy + 1e-4 * fraction * direction.dot(s.gradient) + 1e-15)
      next = moved(q, x, direction, fraction *= 0.5);
    x = next;
  }
  const Vector3d lip = x[std::size_t(q.node(0, 0, q.size(2) - 1))];
  return 2 * lip[1];
}

}  // namespace turgor
