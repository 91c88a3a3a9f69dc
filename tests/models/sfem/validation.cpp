// Bodies with known solutions: Hooke's law, Timoshenko's beam, Cook's panel.
#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {
namespace {

/// Nodal forces of a traction of `total` [N], distributed evenly over the surface where `is_loaded`.
std::vector<Vec3d> traction(const SolidMesh& mesh, const SolidSurface& surface, Vec3d total,
                            const std::function<bool(Vec3d)>& is_loaded) {
  std::vector<Vec3d> force(mesh.vertices.size());
  double sum = 0;
  // Number of triangles per face. In a quadratic face, the last triangle joins the midpoint nodes, which
  // carry the load.
  const std::size_t together = mesh.corners == 8 ? 2 : mesh.corners == 10 ? 4 : 1;
  for (std::size_t n = 0; n < surface.triangles.size(); n += together) {
    const Int3 t = surface.triangles[n + (together == 4 ? 3 : 0)];
    std::vector<int> face{t.x, t.y, t.z};
    if (together == 2) face.push_back(surface.triangles[n + 1].z);
    const auto x = [&](std::size_t corner) { return mesh.vertices[std::size_t(face[corner])]; };
    if (!std::all_of(face.begin(), face.end(),
                     [&](int v) { return is_loaded(mesh.vertices[std::size_t(v)]); }))
      continue;
    const double area = norm(cross(x(1) - x(0), x(2) - x(0))) / (together == 2 ? 1 : 2);  // of rectangles
    sum += area;
    for (const int v : face) force[std::size_t(v)] += total * (area / double(face.size()));
  }
  for (Vec3d& f : force) f = f / sum;
  return force;
}

/// The work-weighted displacement under a traction: Σ f·u / |total| [m].
double deflection(const Body& body, Formulation formulation, Vec3d total,
                  const std::function<bool(Vec3d)>& is_loaded) {
  Model model = build(Exec(2), body, {.formulation = formulation, .touch_depth = 0}).value();
  EXPECT_TRUE(factorize(Exec(2), model));
  const std::vector<Vec3d> force = traction(model.body.mesh, model.surface, total, is_loaded);
  std::vector<double> f(3 * model.vertex.size());
  for (std::size_t i = 0; i < f.size(); i++) f[i] = force[std::size_t(model.vertex[i / 3])][int(i % 3)];
  std::vector<double> u = f;
  solve(*model.factor, u);
  double work = 0;
  for (std::size_t i = 0; i < f.size(); i++) work += f[i] * u[i];
  return work / norm(total);
}

/// Displacement of a cube of 0.1 m with a distorted interior, under a stress on its top. A component of a
/// vertex at x may be held [m].
struct StressedCube {
  SolidMesh mesh;
  std::vector<double> u;

  StressedCube(Case of, const Material& material, double stress, bool (*is_held)(Vec3d x, int axis))
      : mesh(hex_block({0.1, 0.1, 0.1}, {3, 3, 3})) {
    distort(mesh, {0.1, 0.1, 0.1}, 0.006);
    mesh = with_corners(mesh, of.corners);
    const BlockMatrix k = assemble(Exec(1), mesh, std::span(&material, 1),
                                   std::vector<int>(element_count(mesh), 0), of.formulation);
    const auto n = Eigen::Index(mesh.vertices.size());
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (Eigen::Index r = 0; r < n; r++)
      for (std::size_t b = k.row_begin[std::size_t(r)]; b < k.row_begin[std::size_t(r) + 1]; b++)
        for (int i = 0; i < 9; i++)
          full(3 * r + i / 3, 3 * k.column[b] + i % 3) = k.value[9 * b + std::size_t(i)];
    const std::vector<Vec3d> force =
        traction(mesh, surface(mesh), {0, 0, stress * 0.01}, [](Vec3d x) { return x.z > 0.1 - 1e-9; });
    Eigen::VectorXd f(3 * n);
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < 3 * n; i++) {
      f[i] = force[std::size_t(i / 3)][int(i % 3)];
      if (!is_held(mesh.vertices[std::size_t(i / 3)], int(i % 3))) free.push_back(i);
    }
    const Eigen::VectorXd solved = full(free, free).llt().solve(f(free));
    u.assign(std::size_t(3 * n), 0);
    for (std::size_t i = 0; i < free.size(); i++) u[std::size_t(free[i])] = solved[Eigen::Index(i)];
  }
};

// A cube on rollers under tension follows Hooke's law.
TEST(SfemValidation, CubeOnRollersFollowsHooke) {
  constexpr double kYoung = 2e4, kPoisson = 0.4, kStress = 100;
  for (const Case& of : kCases) {
    const StressedCube cube(of, {kYoung, kPoisson}, kStress,
                            [](Vec3d x, int axis) { return x[axis] <= 1e-9; });
    for (std::size_t i = 0; i < cube.u.size(); i++) {
      const double strain = i % 3 == 2 ? kStress / kYoung : -kPoisson * kStress / kYoung;
      EXPECT_NEAR(cube.u[i], strain * cube.mesh.vertices[i / 3][int(i % 3)], 1e-13);
    }
  }
}

// A cube that cannot widen is as stiff as its constrained modulus E (1 − ν)/((1 + ν)(1 − 2 ν)) up to ν =
// 0.499: its volume changes as it should.
TEST(SfemValidation, ConfinedCubeKeepsItsVolume) {
  constexpr double kYoung = 2e4, kStress = -100;
  for (const double poisson : {0.3, 0.49, 0.499}) {
    const double modulus = kYoung * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
    for (const Case& of : kCases) {
      const StressedCube cube(of, {kYoung, poisson}, kStress, [](Vec3d x, int axis) {
        return x[axis] <= 1e-9 || (axis != 2 && x[axis] >= 0.1 - 1e-9);
      });
      for (std::size_t i = 0; i < cube.u.size(); i++) {
        const double strain = i % 3 == 2 ? kStress / modulus : 0;
        EXPECT_NEAR(cube.u[i], strain * cube.mesh.vertices[i / 3][int(i % 3)],
                    1e-5 * 0.1 * -kStress / modulus)
            << of.corners << ", " << poisson;
      }
    }
  }
}

/// Deflection of a cantilever of n × n × 10 n hexahedra under an end force, relative to Timoshenko's beam,
/// minus 1.
double beam_error(int n, double poisson, Formulation formulation) {
  constexpr double kLength = 0.1, kSide = 0.01, kYoung = 1e6, kForce = 1e-3;
  const double inertia = std::pow(kSide, 4) / 12, shear = kYoung / (2 * (1 + poisson));
  const double shape = 10 * (1 + poisson) / (12 + 11 * poisson);  // [Cowper 1966]
  const double expected = kForce * std::pow(kLength, 3) / (3 * kYoung * inertia) +
                          kForce * kLength / (shape * shear * kSide * kSide);
  const Body beam = block_of(hex_block({kLength, kSide, kSide}, {10 * n, n, n}), {kYoung, poisson},
                             [](Vec3d x) { return x.x < 1e-9; });
  const double found =
      deflection(beam, formulation, {0, 0, -kForce}, [=](Vec3d x) { return x.x > kLength - 1e-9; });
  return found / expected - 1;
}

// A cantilever converges to Timoshenko's beam with the second power of the element size.
TEST(SfemValidation, CantileverConvergesQuadratically) {
  for (const Formulation formulation : {Formulation::kStandard, Formulation::kAveraged}) {
    const double middle = beam_error(4, 0, formulation), fine = beam_error(8, 0, formulation);
    EXPECT_NEAR(middle / fine, 4, 0.3) << middle << " " << fine;
    EXPECT_LT(std::abs(fine + (fine - middle) / 3), 0.001) << middle << " " << fine;
  }
}

// A cantilever whose clamp constrains its section is within 1 % of Timoshenko's beam.
TEST(SfemValidation, ClampedCantileverWithinOnePercent) {
  EXPECT_NEAR(beam_error(8, 0.3, Formulation::kAveraged), 0, 0.01);
}

/// Deflection of Cook's panel at its right end [m]: 48 mm long, 44 mm high at the left and 16 mm at the
/// right, 10 mm thick, clamped at the left, with a shear force of 1 N at the right.
double cook(int n, int corners, double poisson, Formulation formulation) {
  SolidMesh mesh = hex_block({0.048, 1, 0.01}, {n, n, n / 4});
  for (Vec3d& x : mesh.vertices) {
    const double along = x.x / 0.048, low = 0.044 * along, high = 0.044 + 0.016 * along;
    x.y = low + (high - low) * x.y;
  }
  mesh = with_corners(mesh, corners);
  const Body panel = block_of(std::move(mesh), {1e5, poisson}, [](Vec3d x) { return x.x < 1e-9; });
  return deflection(panel, formulation, {0, 1, 0}, [](Vec3d x) { return x.x > 0.048 - 1e-9; });
}

// Averaged elements do not lock near incompressibility, standard ones do.
TEST(SfemValidation, AveragedElementsDoNotLock) {
  // Fraction of Cook's deflection that remains when ν changes from 0.3 to 0.49 or 0.499. The exact deflection
  // hardly changes: extrapolated B-bar hexahedra give 23.86, 23.86 and 23.85 mm.
  const auto remaining = [](int corners, double poisson, Formulation formulation) {
    return cook(8, corners, poisson, formulation) / cook(8, corners, 0.3, formulation);
  };
  EXPECT_LT(remaining(8, 0.49, Formulation::kStandard), 0.70);
  EXPECT_LT(remaining(8, 0.499, Formulation::kStandard), 0.45);
  EXPECT_LT(remaining(4, 0.49, Formulation::kStandard), 0.55);
  EXPECT_LT(remaining(4, 0.499, Formulation::kStandard), 0.40);
  EXPECT_GT(remaining(8, 0.49, Formulation::kAveraged), 0.98);
  EXPECT_GT(remaining(8, 0.499, Formulation::kAveraged), 0.98);
  EXPECT_GT(remaining(4, 0.49, Formulation::kAveraged), 0.93);
  EXPECT_GT(remaining(4, 0.499, Formulation::kAveraged), 0.90);
}

// Averaged hexahedra and tetrahedra converge to the same deflection at ν = 0.49.
TEST(SfemValidation, AveragedElementsConvergeAlike) {
  const double reference = 0.02386;  // [m], B-bar hexahedra extrapolated
  const auto error = [&](int n, int corners) {
    return std::abs(cook(n, corners, 0.49, Formulation::kAveraged) / reference - 1);
  };
  EXPECT_LT(error(16, 8), 0.02);
  EXPECT_LT(error(16, 8), 0.35 * error(8, 8));
  EXPECT_LT(error(16, 4), 0.10);
  EXPECT_LT(error(16, 4), 0.45 * error(8, 4));
}

// Near incompressibility, quadratic tetrahedra lose little deflection; averaged linear ones lose more than 15
// %.
TEST(SfemValidation, QuadraticTetrahedraHardlyLock) {
  // The same 8 × 8 × 2 cells; 23.86 mm is the extrapolation of B-bar hexahedra for every ratio.
  for (const auto& [poisson, lost] : {std::pair{0.3, 0.01}, {0.45, 0.02}, {0.49, 0.04}, {0.499, 0.06}}) {
    const double found = cook(8, 10, poisson, Formulation::kStandard);
    std::printf("quadratic, %.3f: %.2f mm\n", poisson, 1e3 * found);
    EXPECT_GT(found, (1 - lost) * 0.02386) << poisson;
    EXPECT_LT(found, 1.01 * 0.02386) << poisson;
    EXPECT_LT(cook(8, 4, poisson, Formulation::kAveraged), 0.85 * found) << poisson;
  }
}

// A quadratic cantilever with one cell across is within 1 % of Timoshenko's beam.
TEST(SfemValidation, QuadraticCantileverWithinOnePercent) {
  constexpr double kLength = 0.1, kSide = 0.01, kYoung = 1e6, kForce = 1e-3;
  const SolidMesh mesh = with_corners(hex_block({kLength, kSide, kSide}, {10, 1, 1}), 10);
  const Body beam = block_of(mesh, {kYoung, 0}, [](Vec3d x) { return x.x < 1e-9; });
  const double shear = kYoung / 2,
               bending = kForce * std::pow(kLength, 3) / (3 * kYoung * std::pow(kSide, 4) / 12);
  const double expected = bending + kForce * kLength / (10.0 / 12 * shear * kSide * kSide);
  const double found =
      deflection(beam, Formulation::kStandard, {0, 0, -kForce}, [](Vec3d x) { return x.x > kLength - 1e-9; });
  EXPECT_NEAR(found / expected, 1, 0.01);
}

// The midpoint node of an edge is fixed if both ends are fixed.
TEST(SfemValidation, MidpointIsFixedBetweenFixedEnds) {
  const Body body = with_middles(
      block_of(tetrahedralize(hex_block({1, 1, 1}, {2, 2, 2})), {}, [](Vec3d x) { return x.z < 1e-9; }));
  ASSERT_EQ(body.fixed.size(), 125u);
  for (std::size_t v = 0; v < body.fixed.size(); v++)
    EXPECT_EQ(body.fixed[v] != 0, body.mesh.vertices[v].z < 1e-9) << v;
}

}  // namespace
}  // namespace turgor::sfem
