// The law of solid tissue is isotropic, in infinite bodies and in bars.
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/models/lattice/cell_body.hpp"
#include "turgor/models/lattice/build/springs.hpp"

namespace turgor::lattice {
namespace {

/// Three axes, six face diagonals, four body diagonals.
const std::vector<Int3> kDirections = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1}, {1, 1, 0},  {1, -1, 0},
                                       {1, 0, 1},  {1, 0, -1}, {0, 1, 1}, {0, 1, -1}, {1, 1, 1},
                                       {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};

// ------------------------------------------------------------ every direction

using Matrix6 = Eigen::Matrix<double, 6, 6>;  // strains xx, yy, zz, yz, xz, xy (angles) to stresses

/// Stiffness of an infinite body of the law's cells, by differences of the energy. A uniform strain is at
/// rest by symmetry.
Matrix6 infinite_body(const CellMatrix& matrix) {
  const auto moved = [](int strain) {
    constexpr int kPair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    Eigen::Matrix<double, 24, 1> u = Eigen::Matrix<double, 24, 1>::Zero();
    const auto [r, c] = kPair[strain];
    for (int n = 0; n < 8; n++) {
      u[3 * n + r] += 0.5 * cell_corner(n)[c];
      u[3 * n + c] += 0.5 * cell_corner(n)[r];
    }
    return u;
  };
  Matrix6 c;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) c(i, j) = moved(i).dot(matrix * moved(j));
  return c;
}

Matrix6 infinite_springs(double volume) {
  const Vec3 step{1, 1, 1};
  const auto rows = homogenized_stiffness(step, calibrate_springs(step, volume), volume);
  Matrix6 c;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) c(i, j) = rows[std::size_t(i)][std::size_t(j)];
  return c;
}

/// Symmetric dyad n m as a stress; as a strain, its last three components count twice.
Eigen::Matrix<double, 6, 1> dyad(Vec3d n, Vec3d m) {
  Eigen::Matrix<double, 6, 1> v;
  v << n.x * m.x, n.y * m.y, n.z * m.z, 0.5 * (n.y * m.z + n.z * m.y), 0.5 * (n.x * m.z + n.z * m.x),
      0.5 * (n.x * m.y + n.y * m.x);
  return v;
}
/// Young's modulus along n.
double young_along(const Matrix6& c, Vec3d n) { return 1 / dyad(n, n).dot(c.inverse() * dyad(n, n)); }
/// Shear modulus for planes across n sliding along m.
double shear_along(const Matrix6& c, Vec3d n, Vec3d m) {
  return 0.25 / dyad(n, m).dot(c.inverse() * dyad(n, m));
}

/// Two directions orthogonal to n and to each other.
std::pair<Vec3d, Vec3d> across(Vec3d n) {
  const Vec3d aside = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  const Vec3d m = normalized(aside - n * dot(aside, n));
  return {m, cross(n, m)};
}

// An infinite body has E and G in thirteen directions.
TEST(LatticeSolid, InfiniteBodyIsIsotropic) {
  for (const double poisson : {0.0, 0.3, 0.45, 0.49}) {
    const Matrix6 c = infinite_body(solid_matrix(1, poisson));
    const double shear = 0.5 / (1 + poisson);
    for (const Int3 direction : kDirections) {
      const Vec3d n = normalized(Vec3d(direction));
      const auto [m, l] = across(n);
      EXPECT_NEAR(young_along(c, n), 1, 1e-3) << "E, v " << poisson;
      EXPECT_NEAR(shear_along(c, n, m), shear, 1e-3 * shear) << "G, v " << poisson;
      EXPECT_NEAR(shear_along(c, n, l), shear, 1e-3 * shear) << "G, v " << poisson;
    }
  }
}

/// Energy of a cube of cells whose surface moves as in an infinite bent or twisted bar, relative to that of
/// the bar. The cube's second moment is the same about every axis.
double cube_of_bar(int n, const CellMatrix& matrix, double poisson, Vec3d along, Vec3d up, bool twisted) {
  CellBody cube;
  for (int k = 0; k < n; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) cube.cells.push_back({i, j, k});
  cube.is_end.assign(cube.cells.size(), 0);
  const Vec3d side = cross(up, along);
  const auto field = [=](Vec3d node) {
    const Vec3d x = node - Vec3d{0.5 * n, 0.5 * n, 0.5 * n};
    const double a = dot(x, along), s = dot(x, side), z = dot(x, up);
    if (twisted) return side * (-a * z) + up * (a * s);
    return along * (a * z) - side * (poisson * s * z) - up * (0.5 * (a * a + poisson * (z * z - s * s)));
  };
  const auto held = [n](Vec3d x) {
    return std::min({x.x, x.y, x.z}) < 0.5 || std::max({x.x, x.y, x.z}) > n - 0.5;
  };
  const double second = std::pow(n, 5) / 12;  // ∫ z² over the cube
  const double bar = twisted ? 0.5 / (1 + poisson) * second : 0.5 * second;
  return held_energies(cube, matrix, {field}, held)[0] / bar;
}

// A cube of four cells has E I and G J within 8 % in thirteen directions.
TEST(LatticeSolid, FourCellsBendAndTwist) {
  for (const double poisson : {0.0, 0.3, 0.45})
    for (const Int3 direction : kDirections) {
      const CellMatrix matrix = solid_matrix(1, poisson);
      const Vec3d n = normalized(Vec3d(direction));
      const auto [m, l] = across(n);
      for (const Vec3d up : {m, l}) {
        EXPECT_NEAR(cube_of_bar(4, matrix, poisson, n, up, false), 1, 0.08)
            << "E I, v " << poisson << ", along " << direction.x << direction.y << direction.z;
        EXPECT_NEAR(cube_of_bar(4, matrix, poisson, n, up, true), 1, 0.08)
            << "G J, v " << poisson << ", along " << direction.x << direction.y << direction.z;
      }
    }
}

// Prints the moduli of springs, volume constraints, cells and tetrahedra by direction; springs alone are
// anisotropic.
TEST(LatticeSolid, TableOfModuliByDirection) {
  constexpr double kPoisson = 0.45;
  const Matrix6 springs = infinite_springs(0), volumes = infinite_springs(2);
  const CellMatrix cells = solid_matrix(1, kPoisson), kuhn = kuhn_matrix(1, kPoisson, false),
                   mirrored = kuhn_matrix(1, kPoisson, true);
  const Matrix6 solid = infinite_body(cells);
  std::printf("E and G relative to the material; E I and G J of 4 cells\n%10s %14s %14s %29s %15s %15s\n",
              "along", "springs", "with volumes", "cells", "Kuhn", "mirrored");
  double least = 9, most = 0;
  for (const Int3 d : kDirections) {
    const Vec3d n = normalized(Vec3d(d));
    const auto [m, l] = across(n);
    const auto moduli = [&, side = m](const Matrix6& c, double poisson) {
      std::printf("  %.2f  %.2f |", young_along(c, n), shear_along(c, n, side) * 2 * (1 + poisson));
    };
    std::printf("%3d %2d %2d |", d.x, d.y, d.z);
    moduli(springs, 0.25), moduli(volumes, 0.25), moduli(solid, kPoisson);
    for (const CellMatrix* matrix : {&cells, &kuhn, &mirrored})
      std::printf("  %.2f  %.2f |", cube_of_bar(4, *matrix, kPoisson, n, m, false),
                  cube_of_bar(4, *matrix, kPoisson, n, m, true));
    std::printf("\n");
    least = std::min(least, young_along(springs, n)), most = std::max(most, young_along(springs, n));
  }
  EXPECT_GT(most / least, 1.3) << "springs alone are not isotropic";
}

// ------------------------------------------------------------ bars with free sides

struct Bar {
  CellBody body;
  Vec3d along, across, third;
};

/// The cells whose centers lie in a bar of `thick` × `thick` × `length` cells along a direction.
Bar bar_along(Int3 direction, double thick, double length) {
  Bar bar;
  bar.along = normalized(Vec3d(direction));
  std::tie(bar.across, bar.third) = across(bar.along);
  const int reach = int(length);
  for (int k = -reach; k <= reach; k++)
    for (int j = -reach; j <= reach; j++)
      for (int i = -reach; i <= reach; i++) {
        const Vec3d x = Vec3d(Int3{i, j, k}) + Vec3d{0.5, 0.5, 0.5};
        const double far = std::max(std::abs(dot(x, bar.across)), std::abs(dot(x, bar.third)));
        const double end = std::abs(dot(x, bar.along));
        if (far > 0.5 * thick + 1e-9 || end > 0.5 * length + 1e-9) continue;
        bar.body.cells.push_back({i, j, k});
        bar.body.is_end.push_back(end > 0.5 * length - 2);
      }
  return bar;
}

/// Displacement fields of the bar's ends: stretch, and bending in either plane.
std::vector<std::function<Vec3d(Vec3d)>> ends_moved(const Bar& bar) {
  const auto sign = [along = bar.along](Vec3d x) { return dot(x, along) > 0 ? 1.0 : -1.0; };
  const auto turned = [=](Vec3d axis) { return [=](Vec3d x) { return cross(axis, x) * sign(x); }; };
  return {[=, along = bar.along](Vec3d x) { return along * sign(x); }, turned(bar.third), turned(bar.across)};
}

/// Stiffness of a bar far from its ends relative to E A, E I and E I. Two bars of different length eliminate
/// the effect of the ends. A and I are those of the cells, including the staircase surface.
std::array<double, 3> bar_stiffness(Int3 direction, double thick, double poisson) {
  const double pitch = norm(Vec3d(direction)), more = 2 * std::round(6 / pitch) * pitch;
  const Bar bars[2] = {bar_along(direction, thick, 14), bar_along(direction, thick, 14 + more)};
  const CellMatrix matrix = solid_matrix(1, poisson);
  std::vector<double> energies[2];
  double moment[3] = {};
  for (const int n : {0, 1}) {
    energies[n] = held_energies(bars[n].body, matrix, ends_moved(bars[n]));
    for (const Int3 c : bars[n].body.cells) {
      const Vec3d x = Vec3d(c) + Vec3d{0.5, 0.5, 0.5};
      const double share = (n == 1 ? 1 : -1) / more;
      moment[0] += share, moment[1] += share * (std::pow(dot(x, bars[n].across), 2) + 1.0 / 12);
      moment[2] += share * (std::pow(dot(x, bars[n].third), 2) + 1.0 / 12);
    }
  }
  std::array<double, 3> found{};
  for (std::size_t f = 0; f < 3; f++) found[f] = more / (2 / energies[1][f] - 2 / energies[0][f]) / moment[f];
  return found;
}

// A bar of four cells has E A and E I along axes and face diagonals.
TEST(LatticeSolid, BarsAlongAxesAndFaceDiagonals) {
  for (const double poisson : {0.3, 0.49})
    for (const Int3 direction : {Int3{1, 0, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, -1}}) {
      const auto [stretch, bend, aside] = bar_stiffness(direction, 4.3, poisson);
      std::printf("v %.2f along %2d %2d %2d: E A %.3f, E I %.3f and %.3f\n", poisson, direction.x,
                  direction.y, direction.z, stretch, bend, aside);
      EXPECT_NEAR(stretch, 1, 0.08);
      EXPECT_NEAR(bend, 1, 0.08) << "does not lock";
      EXPECT_NEAR(aside, 1, 0.08) << "does not lock";
    }
}

// A bar along a body diagonal nearly has E A; its staircase surface reduces the bending stiffness.
TEST(LatticeSolid, BarAlongBodyDiagonal) {
  const auto [stretch, bend, aside] = bar_stiffness({1, 1, 1}, 6, 0.3);
  std::printf("along 1 1 1: E A %.3f, E I %.3f and %.3f\n", stretch, bend, aside);
  EXPECT_NEAR(stretch, 1, 0.08);
  for (const double ratio : {bend, aside}) {
    EXPECT_LT(ratio, 1) << "a staircase carries less than a plane side";
    EXPECT_GT(ratio, 0.83);
  }
}

}  // namespace
}  // namespace turgor::lattice
