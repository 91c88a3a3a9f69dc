// Bodies whose answers are known from elsewhere: Hooke's law, Timoshenko's beam, Cook's panel.
#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {
namespace {

/// Nodal forces of a traction of `total` [N] spread evenly over the surface where `is_loaded`.
std::vector<Vec3d> traction(const SolidMesh& mesh, const SolidSurface& surface, Vec3d total,
                            const std::function<bool(Vec3d)>& is_loaded) {
  std::vector<Vec3d> force(mesh.vertices.size());
  double sum = 0;
  // Triangles that are one face; of a quadratic one the last lies between the middles, which bear all.
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

TEST(SfemValidation, a_cube_on_rollers_under_tension_follows_hooke_s_law) {
  constexpr double kYoung = 2e4, kPoisson = 0.4, kStress = 100;
  for (const auto [corners, formulation] : kCases) {
    SolidMesh mesh = hex_block({0.1, 0.1, 0.1}, {3, 3, 3});
    distort(mesh, {0.1, 0.1, 0.1}, 0.006);
    mesh = with_corners(mesh, corners);
    const Material material{kYoung, kPoisson};
    const BlockMatrix k = assemble(Exec(1), mesh, std::span(&material, 1),
                                   std::vector<int>(element_count(mesh), 0), formulation);
    const auto n = Eigen::Index(mesh.vertices.size());
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (Eigen::Index r = 0; r < n; r++)
      for (std::size_t b = k.row_begin[std::size_t(r)]; b < k.row_begin[std::size_t(r) + 1]; b++)
        for (int i = 0; i < 9; i++)
          full(3 * r + i / 3, 3 * k.column[b] + i % 3) = k.value[9 * b + std::size_t(i)];
    const std::vector<Vec3d> force =
        traction(mesh, surface(mesh), {0, 0, kStress * 0.01}, [](Vec3d x) { return x.z > 0.1 - 1e-9; });
    Eigen::VectorXd f(3 * n);
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < 3 * n; i++) {
      f[i] = force[std::size_t(i / 3)][int(i % 3)];
      if (mesh.vertices[std::size_t(i / 3)][int(i % 3)] > 1e-9) free.push_back(i);  // others are on rollers
    }
    const Eigen::VectorXd u = full(free, free).llt().solve(f(free));
    for (std::size_t i = 0; i < free.size(); i++) {
      const int axis = int(free[i] % 3);
      const double strain = axis == 2 ? kStress / kYoung : -kPoisson * kStress / kYoung;
      EXPECT_NEAR(u[Eigen::Index(i)], strain * mesh.vertices[std::size_t(free[i] / 3)][axis], 1e-13);
    }
  }
}

/// What a cantilever of n × n × 10 n hexahedra bends under a force at its end, in parts of Timoshenko's beam,
/// less 1.
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

TEST(SfemValidation, a_cantilever_converges_to_timoshenko_s_beam_with_the_second_power_of_the_step) {
  for (const Formulation formulation : {Formulation::kStandard, Formulation::kAveraged}) {
    const double middle = beam_error(4, 0, formulation), fine = beam_error(8, 0, formulation);
    EXPECT_NEAR(middle / fine, 4, 0.3) << middle << " " << fine;
    EXPECT_LT(std::abs(fine + (fine - middle) / 3), 0.001) << middle << " " << fine;
  }
}

TEST(SfemValidation, a_cantilever_whose_clamp_hinders_its_section_is_within_a_percent_of_timoshenko_s_beam) {
  EXPECT_NEAR(beam_error(8, 0.3, Formulation::kAveraged), 0, 0.01);
}

/// Cook's panel: 48 mm long, 44 mm high at the left and 16 at the right, 10 mm thick, clamped at the left and
/// sheared at the right by 1 N. Its deflection there [m].
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

TEST(SfemValidation, averaged_elements_do_not_lock_when_nearly_incompressible_but_standard_ones_do) {
  // What elements of a kind lose of Cook's deflection when ν goes from 0.3 to 0.49 or 0.499. The body itself
  // hardly loses anything: B-bar hexahedra extrapolated give 23.86, 23.86 and 23.85 mm.
  const auto kept = [](int corners, double poisson, Formulation formulation) {
    return cook(8, corners, poisson, formulation) / cook(8, corners, 0.3, formulation);
  };
  EXPECT_LT(kept(8, 0.49, Formulation::kStandard), 0.70);
  EXPECT_LT(kept(8, 0.499, Formulation::kStandard), 0.45);
  EXPECT_LT(kept(4, 0.49, Formulation::kStandard), 0.55);
  EXPECT_LT(kept(4, 0.499, Formulation::kStandard), 0.40);
  EXPECT_GT(kept(8, 0.49, Formulation::kAveraged), 0.98);
  EXPECT_GT(kept(8, 0.499, Formulation::kAveraged), 0.98);
  EXPECT_GT(kept(4, 0.49, Formulation::kAveraged), 0.93);
  EXPECT_GT(kept(4, 0.499, Formulation::kAveraged), 0.90);
}

TEST(SfemValidation, both_averaged_kinds_converge_to_the_same_deflection_at_a_ratio_of_0_49) {
  const double reference = 0.02386;  // [m], B-bar hexahedra extrapolated
  const auto error = [&](int n, int corners) {
    return std::abs(cook(n, corners, 0.49, Formulation::kAveraged) / reference - 1);
  };
  EXPECT_LT(error(16, 8), 0.02);
  EXPECT_LT(error(16, 8), 0.35 * error(8, 8));
  EXPECT_LT(error(16, 4), 0.10);
  EXPECT_LT(error(16, 4), 0.45 * error(8, 4));
}

TEST(SfemValidation,
     quadratic_tetrahedra_lose_little_near_incompressibility_where_averaged_ones_lose_a_fifth) {
  // The same 8 × 8 × 2 cells; 23.86 mm is what B-bar hexahedra extrapolate to at every ratio.
  for (const auto& [poisson, lost] : {std::pair{0.3, 0.01}, {0.45, 0.02}, {0.49, 0.04}, {0.499, 0.06}}) {
    const double found = cook(8, 10, poisson, Formulation::kStandard);
    std::printf("quadratic, %.3f: %.2f mm\n", poisson, 1e3 * found);
    EXPECT_GT(found, (1 - lost) * 0.02386) << poisson;
    EXPECT_LT(found, 1.01 * 0.02386) << poisson;
    EXPECT_LT(cook(8, 4, poisson, Formulation::kAveraged), 0.85 * found) << poisson;
  }
}

TEST(SfemValidation, a_quadratic_cantilever_of_one_cell_across_is_within_a_percent_of_timoshenko_s_beam) {
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

TEST(SfemValidation, the_middle_of_an_edge_is_held_where_both_of_its_ends_are) {
  const Body body = with_middles(
      block_of(tetrahedralize(hex_block({1, 1, 1}, {2, 2, 2})), {}, [](Vec3d x) { return x.z < 1e-9; }));
  ASSERT_EQ(body.fixed.size(), 125u);
  for (std::size_t v = 0; v < body.fixed.size(); v++)
    EXPECT_EQ(body.fixed[v] != 0, body.mesh.vertices[v].z < 1e-9) << v;
}

}  // namespace
}  // namespace turgor::sfem
