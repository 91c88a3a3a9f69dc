// Laws of solid cells that stiffen: forces against differences of the energy, and blocks against closed
// forms.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"
#include "turgor/models/lattice/mechanics/ogden.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);

struct Law {
  SolidEnergy energy;
  double stiffening, poisson;
};
const std::vector<Law> kLaws = {{SolidEnergy::kNeoHookean, 0, 0.4},   {SolidEnergy::kExponential, 0, 0.3},
                                {SolidEnergy::kExponential, 3, 0.45}, {SolidEnergy::kExponential, 20, 0.49},
                                {SolidEnergy::kOgden, 2, 0.45},       {SolidEnergy::kOgden, -18.7, 0.45},
                                {SolidEnergy::kOgden, 7, 0.3}};

/// One cell of a law with moduli of a unit volume and E = 1.
struct OneCell {
  Law law;
  Vec3 spacing{1.2f, 0.9f, 1.1f};
  Real shear, bulk, stiffening;

  explicit OneCell(Law l) : law(l) {
    const LawRatios ratios = law_ratios(law.energy, law.poisson);
    shear = Real(ratios.shear), bulk = Real(ratios.bulk), stiffening = Real(law.stiffening);
  }
  double diagonal2() const { return dot(Vec3d(spacing), Vec3d(spacing)); }
  double energy(const Vec3d (&u)[kCellCorners]) const {
    const CellDeformation d = cell_deformation(u, spacing);
    return law_energy(law.energy, d.f, {shear, bulk, stiffening}) +
           shear * hourglass_over_shear(law.energy) / diagonal2() * d.hourglass / 16;
  }
  NodeSystem system(const Vec3d (&u)[kCellCorners], int at) const {
    const Real hourglass = Real(hourglass_over_shear(law.energy) / diagonal2() / 8);
    const CellLawView view{.energy = law.energy,
                           .energies = nullptr,
                           .slope = solid_law(spacing, law.poisson).slope,
                           .hourglass = hourglass,
                           .hourglasses = {hourglass, hourglass, hourglass},
                           .shear = &shear,
                           .bulk = &bulk,
                           .stiffening = &stiffening,
                           .instant = 1,
                           .instants = nullptr,
                           .history = {}};
    Vec3 d[kCellCorners];
    for (int c = 0; c < kCellCorners; c++) d[c] = Vec3(u[c] - u[at]);
    NodeSystem s;
    add_law_cell(s, cell_gradient(d, at, view.slope), at, view, 0, 1);
    return s;
  }
};

/// Least eigenvalue of a Hessian, over its largest.
double least_share(const NodeSystem& s) {
  Eigen::Matrix3d h;
  h << s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz;
  const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(h).eigenvalues();
  return values[0] / values[2];
}

// The force of a cell is the negative gradient of its energy up to large strains, also of inverted cells.
TEST(SolidLaws, ForceIsGradient) {
  std::mt19937 engine(7);
  for (const Law& law : kLaws)
    for (int n = 0; n < 60; n++) {
      const OneCell cell(law);
      const double size = n < 20 ? 0.02 : n < 40 ? 0.2 : 0.7;
      std::uniform_real_distribution<double> any(-size, size);
      Vec3d u[kCellCorners];
      for (Vec3d& x : u) x = {any(engine), any(engine), any(engine)};
      const int at = n % kCellCorners;
      const NodeSystem s = cell.system(u, at);
      EXPECT_GT(least_share(s), -1e-5) << "positive semidefinite";
      const double scale = std::max(norm(Vec3d(s.f)), 1e-3);
      for (int axis = 0; axis < 3; axis++) {
        const double h = 1e-6;
        Vec3d up[kCellCorners], down[kCellCorners];
        std::copy(u, u + kCellCorners, up), std::copy(u, u + kCellCorners, down);
        up[at][axis] += h, down[at][axis] -= h;
        EXPECT_NEAR(double(s.f[axis]), -(cell.energy(up) - cell.energy(down)) / (2 * h), 2e-3 * scale)
            << "energy " << int(law.energy) << ", b " << law.stiffening << ", case " << n;
      }
    }
}

// The Hessian of the exponential law is the second derivative of its energy.
TEST(SolidLaws, ExponentialHessianIsExact) {
  std::mt19937 engine(3);
  for (const Law& law : kLaws) {
    if (law.energy != SolidEnergy::kExponential) continue;
    for (int n = 0; n < 20; n++) {
      const OneCell cell(law);
      std::uniform_real_distribution<double> any(-0.15, 0.15);
      Vec3d u[kCellCorners];
      for (Vec3d& x : u) x = {any(engine), any(engine), any(engine)};
      const int at = n % kCellCorners;
      const NodeSystem s = cell.system(u, at);
      const double h = 1e-4, found[3] = {s.xx, s.yy, s.zz};
      for (int axis = 0; axis < 3; axis++) {
        Vec3d up[kCellCorners], down[kCellCorners];
        std::copy(u, u + kCellCorners, up), std::copy(u, u + kCellCorners, down);
        up[at][axis] += h, down[at][axis] -= h;
        // the hourglass part is half of its own second derivative, as in solid cells
        const double hourglass = double(cell.shear) * 4 / cell.diagonal2() / 16;
        const double second = (cell.energy(up) - 2 * cell.energy(u) + cell.energy(down)) / (h * h);
        EXPECT_NEAR(found[axis], second, 2e-3 * second + 2 * hourglass) << "b " << law.stiffening;
      }
    }
  }
}

// Bounds by bits are those of numbers, for both signs, zeros and infinities.
TEST(SolidLaws, BoundsByBitsMatchNumbers) {
  const Real most = std::numeric_limits<Real>::infinity();
  std::vector<Real> numbers = {0, Real(1e-40), Real(1e-30),  Real(0.0999), Real(0.1),
                               1, 10,          Real(10.001), most};
  for (std::size_t n = numbers.size(); n-- > 0;) numbers.push_back(-numbers[n]);
  for (const Real bound : {Real(0), Real(0.1), Real(10)})
    for (const Real a : numbers) {
      EXPECT_EQ(at_least(a, bound), std::max(a, bound)) << a;
      EXPECT_EQ(at_most(a, bound), std::min(a, bound)) << a;
      EXPECT_EQ(within(a, bound), std::clamp(a, -bound, bound)) << a;
    }
}

// Exponentials, roots and logarithms of lanes are accurate to a few units in the last digit.
TEST(SolidLaws, LaneFunctionsAreAccurate) {
  for (double x = -10; x < 10; x += 0.01) {
    EXPECT_NEAR(double(lane_exp(Real(x))) / std::exp(double(Real(x))), 1, 5e-7);
    EXPECT_NEAR(double(lane_expm1(Real(x))), std::expm1(double(Real(x))),
                5e-7 * std::abs(std::expm1(x)) + 1e-12);
    const double a = std::exp(0.7 * x);
    EXPECT_NEAR(double(lane_inverse_cube_root(Real(a))) * std::cbrt(double(Real(a))), 1, 5e-7);
    EXPECT_NEAR(double(lane_log1p(Real(a - 1))), std::log1p(double(Real(a - 1))), 1e-6 * (0.1 + std::abs(x)));
  }
  for (const double x : {1e-7, -1e-6, 3e-5, -2e-4})
    EXPECT_NEAR(double(lane_log1p(Real(x))) / std::log1p(double(Real(x))), 1, 1e-6);
}

// ------------------------------------------------------------ closed forms

/// Derivative of the energy by the principal stretches, from the definitions with stretches alone [1].
Vec3d principal_stress(const Law& law, Vec3d l) {
  const double j = l.x * l.y * l.z, root = std::cbrt(j);
  const double mu = 0.5 / (1 + law.poisson), kappa = 1 / (3 * (1 - 2 * law.poisson));
  Vec3d w;  // λ ∂W/∂λ
  if (law.energy == SolidEnergy::kExponential) {
    const double i1 = dot(l, l) / (root * root);
    for (int i = 0; i < 3; i++)
      w[i] = mu * std::exp(law.stiffening * (i1 - 3)) * (l[i] * l[i] / (root * root) - i1 / 3);
  } else {
    Vec3d p;
    for (int i = 0; i < 3; i++) p[i] = std::pow(l[i] / root, law.stiffening);
    for (int i = 0; i < 3; i++) w[i] = 2 * mu / law.stiffening * (p[i] - (p.x + p.y + p.z) / 3);
  }
  Vec3d stress;
  for (int i = 0; i < 3; i++) stress[i] = (w[i] + kappa * (j - 1) * j) / l[i];
  return stress;
}

/// Stretches with given values along some axes and no stress along the others, by Newton with differences.
Vec3d free_stretches(const Law& law, Vec3d l, std::array<bool, 3> is_free) {
  for (int n = 0; n < 100; n++)
    for (int i = 0; i < 3; i++) {
      if (!is_free[std::size_t(i)]) continue;
      Vec3d more = l;
      more[i] += 1e-6;
      const double stress = principal_stress(law, l)[i];
      l[i] -= stress / ((principal_stress(law, more)[i] - stress) / 1e-6);
    }
  return l;
}

struct Deformed {
  Mat3d f, stress;  // F and first Piola-Kirchhoff stress over E
};
/// Stretches along three directions.
Deformed stretched(const Law& law, const Mat3d& axes, Vec3d l) {
  const Vec3d p = principal_stress(law, l);
  Deformed d{Mat3d{{Vec3d{}, Vec3d{}, Vec3d{}}}, Mat3d{{Vec3d{}, Vec3d{}, Vec3d{}}}};
  for (int i = 0; i < 3; i++)
    for (int c = 0; c < 3; c++) {
      const Vec3d n = axes.column[std::size_t(i)];
      d.f.column[std::size_t(c)] += n * (l[i] * n[c]);
      d.stress.column[std::size_t(c)] += n * (p[i] * n[c]);
    }
  return d;
}
Mat3d oblique_axes() {
  const Vec3d n = normalized(Vec3d{1, 2, 3}), m = normalized(cross(n, Vec3d{1, 0, 0}));
  return {{n, m, cross(n, m)}};
}

Params law_params(const Law& law, int sweeps) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.energy = law.energy;
  params.tissue.stiffening = law.stiffening;
  params.tissue.poisson = law.poisson;
  params.solver = {.sweeps = sweeps, .damping = 10};
  return params;
}

/// Loads P N on the sides of a block, for a homogeneous stress P.
std::vector<NodeLoad> side_loads(const Model& model, const Mat3d& stress) {
  const Lattice& l = model.anatomy.lattice;
  const Vec3d h(l.spacing);
  std::vector<NodeLoad> loads;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 p{i, j, k};
        Vec3d force;
        for (int axis = 0; axis < 3; axis++) {
          const double side = p[axis] == 0 ? -1 : p[axis] == l.size[axis] - 1 ? 1 : 0;
          double area = 1;
          for (const int other : {(axis + 1) % 3, (axis + 2) % 3})
            area *= h[other] * (p[other] == 0 || p[other] == l.size[other] - 1 ? 0.5 : 1);
          force += stress.column[std::size_t(axis)] * (side * area);
        }
        if (norm(force) > 0) loads.push_back({node_slot(l, p), Vec3(force)});
      }
  return loads;
}

/// Deformation gradient of a free block at rest under the loads of a stress, from its corner nodes.
Mat3d settled(const Model& model, double young, const Mat3d& stress, int steps) {
  Mat3d scaled;
  for (std::size_t c = 0; c < 3; c++) scaled.column[c] = stress.column[c] * young;
  const std::vector<NodeLoad> all = side_loads(model, scaled);
  State state = make_state(model);
  std::vector<NodeLoad> loads = all;
  for (int n = 0; n < steps; n++) {
    // a ramp over the first half
    const double share = std::min(1.0, 2.0 * (n + 1) / steps);
    for (std::size_t i = 0; i < loads.size(); i++) loads[i].force = all[i].force * Real(share);
    EXPECT_TRUE(step(kTwo, model, state, {.loads = loads}, 1.0 / 60).finite);
  }
  const Lattice& l = model.anatomy.lattice;
  Mat3d f;
  for (int axis = 0; axis < 3; axis++) {
    Int3 a{}, b{};
    b[axis] = l.size[axis] - 1;
    f.column[std::size_t(axis)] =
        (Vec3d(position(model, state.motion, b)) - Vec3d(position(model, state.motion, a))) /
        (double(l.spacing[axis]) * (l.size[axis] - 1));
  }
  return f;
}

/// Stretch along a direction of a deformed block.
double stretch_along(const Mat3d& f, Vec3d n) { return norm(f * n); }

/// First Piola-Kirchhoff stress over E of a simple shear by γ along m in planes across n: J = 1, so that it
/// has no pressure of the volume. Exponential: Ī₁ = 3 + γ². Ogden: λ and 1/λ with λ − 1/λ = γ, by Rivlin's
/// coaxial form.
Mat3d simple_shear_stress(const Law& law, Vec3d m, Vec3d n, double gamma) {
  const double mu = 0.5 / (1 + law.poisson), i1 = 3 + gamma * gamma;
  const double l = 0.5 * (gamma + std::sqrt(gamma * gamma + 4)), a = law.stiffening;
  const double mean = (std::pow(l, a) + std::pow(l, -a) + 1) / 3;
  // Kirchhoff stress along m, n and their normal: the axis of λ has the slope λ against n
  const double high = 2 * mu / a * (std::pow(l, a) - mean), low = 2 * mu / a * (std::pow(l, -a) - mean),
               third = 2 * mu / a * (1 - mean), c2 = l * l / (1 + l * l), s2 = 1 / (1 + l * l);
  Mat3d p;
  for (int c = 0; c < 3; c++) {
    Vec3d unit;
    unit[c] = 1;
    const Vec3d back = unit - n * (gamma * m[c]);  // column of F⁻ᵀ
    if (law.energy == SolidEnergy::kExponential) {
      const Vec3d f = unit + m * (gamma * n[c]);
      p.column[std::size_t(c)] = (f - back * (i1 / 3)) * (mu * std::exp(law.stiffening * gamma * gamma));
    } else {
      const double mm = high * c2 + low * s2, nn = high * s2 + low * c2,
                   mn = (high - low) * std::sqrt(c2 * s2);
      const Vec3d k = cross(m, n);
      p.column[std::size_t(c)] = m * (mm * dot(m, back) + mn * dot(n, back)) +
                                 n * (mn * dot(m, back) + nn * dot(n, back)) + k * (third * dot(k, back));
    }
  }
  return p;
}

const double kBlockYoung = 2e4;
Model free_block(const Law& law, Int3 size) {
  return block_model({.size = size, .spacing = 0.004, .young = kBlockYoung, .skin_on_top = false},
                     law_params(law, 12));
}

// A free block under the loads of a closed form has its stretches, along an oblique direction.
TEST(SolidLaws, BlocksMatchClosedForms) {
  const Mat3d axes = oblique_axes();
  struct Case {
    Law law;
    double stretch;
    bool biaxial;
  };
  for (const Case& c : {Case{{SolidEnergy::kExponential, 4, 0.45}, 1.4, false},
                        {{SolidEnergy::kExponential, 12, 0.4}, 1.25, true},
                        {{SolidEnergy::kOgden, -9, 0.45}, 1.3, false},
                        {{SolidEnergy::kOgden, 5, 0.3}, 1.15, true}}) {
    const Vec3d given = c.biaxial ? Vec3d{c.stretch, c.stretch, 1} : Vec3d{c.stretch, 1, 1};
    const Vec3d l = free_stretches(c.law, given, {false, !c.biaxial, true});
    const Deformed d = stretched(c.law, axes, l);
    const Mat3d f = settled(free_block(c.law, {4, 3, 3}), kBlockYoung, d.stress, 90);
    for (int i = 0; i < 3; i++)
      EXPECT_NEAR(stretch_along(f, axes.column[std::size_t(i)]), l[i], 0.002)
          << "energy " << int(c.law.energy) << ", axis " << i << ", stretch " << c.stretch;
  }
}

// The corners of a cell that is sheared by 40 % in oblique planes bear the forces of the closed form, −V P g.
TEST(SolidLaws, SimpleShearMatchesClosedForm) {
  const Mat3d axes = oblique_axes();
  for (const Law& law : {Law{SolidEnergy::kExponential, 6, 0.45}, {SolidEnergy::kOgden, -9, 0.45}}) {
    const OneCell cell(law);
    const Vec3d m = axes.column[0], n = axes.column[1];
    const Mat3d stress = simple_shear_stress(law, m, n, 0.4);
    Vec3d u[kCellCorners];
    for (int c = 0; c < kCellCorners; c++)
      u[c] = m * (0.4 * dot(n, hadamard(Vec3d(cell_corner(c)), Vec3d(cell.spacing))));
    for (int at = 0; at < kCellCorners; at++) {
      const Vec3d slope(solid_law(cell.spacing, 0).slope),
          expected = -(stress * hadamard(Vec3d(corner_sign(at)), slope));
      const Vec3d found(cell.system(u, at).f);
      EXPECT_LT(norm(found - expected), 2e-4 * norm(expected))
          << "energy " << int(law.energy) << ", corner " << at;
    }
  }
}

/// Motion and elastic energy of a body [J].
double whole_energy(const Model& model, const State& state) {
  double sum = energy(kTwo, model, state);
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const Real w = model.anatomy.inverse_mass[s]; w > 0)
      sum += 0.5 * dot(Vec3d(state.motion.v[s]), Vec3d(state.motion.v[s])) / double(w);
  return sum;
}

// A block that is let go from large strains, crushed cells among them, loses energy in every step and comes
// to rest.
TEST(SolidLaws, ReleasedBlockLosesEnergy) {
  for (const Law& law : {Law{SolidEnergy::kExponential, 20, 0.45}, {SolidEnergy::kOgden, -20, 0.45}}) {
    const Model model = free_block(law, {5, 4, 4});
    State state = make_state(model);
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> any(-0.0015, 0.0015);
    const Lattice& l = model.anatomy.lattice;
    for (int k = 0; k < l.size.z; k++)
      for (int j = 0; j < l.size.y; j++)
        for (int i = 0; i < l.size.x; i++)
          state.motion.u.set(std::size_t(node_slot(l, {i, j, k})),
                             Vec3(Vec3d{0.0016 * i + any(engine), any(engine) - 0.0008 * j, any(engine)}));
    const double first = whole_energy(model, state);
    double last = first;
    for (int n = 0; n < 60; n++) {
      ASSERT_TRUE(step(kTwo, model, state, {}, 1.0 / 60).finite);
      const double now = whole_energy(model, state);
      EXPECT_LT(now, last + 1e-6 * first) << "step " << n << ", energy " << int(law.energy);
      last = now;
    }
    EXPECT_LT(last, 1e-4 * first);
  }
}

}  // namespace
}  // namespace turgor::lattice
