// Problems of FEBio's test suite (github.com/febiosoftware/TestSuite, Verify4) whose materials are laws of
// this project, beside the results stored there (code/linuxGoldStandards.py): the norm of all free
// displacements. The meshes are coarse, so a result belongs to its elements. The laws are therefore solved in
// the same ones, hexahedra with a mean dilatation [Simo, Taylor, Pister 1985]. Stress and tangent are
// differences of a law's energy.
//
//   E(u) = Σ_e ( Σ_g V/8 W(F_g) + V κ/2 (J̄ − 1)² ),   J̄ = Σ_g det F_g/8
//
// FEBio has κ/2 (ln J̄)², which is the same for the small J̄ − 1 of these problems.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "app/measured_table.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor {

namespace {

using lattice::LawModuli, lattice::SolidEnergy;

constexpr const char* kFebioSource = "FEBio test suite, stored result";

/// Block of 8 × 4 × 4 cubes; nodes count along z first, then y, then x.
struct CubeMesh {
  static constexpr int kX = 8, kY = 4, kZ = 4;
  static constexpr double kEdge = 0.25;
  static constexpr int kNodes = (kX + 1) * (kY + 1) * (kZ + 1), kCubes = kX * kY * kZ;
  static constexpr int kUnknowns = 3 * kNodes;
  /// Largest difference of two unknowns of one cube.
  static constexpr int kBand = 3 * ((kY + 1) * (kZ + 1) + (kZ + 1) + 1) + 2;

  static int node(int i, int j, int k) { return (i * (kY + 1) + j) * (kZ + 1) + k; }
  static std::array<int, 8> corners(int cube) {
    const int k = cube % kZ, j = cube / kZ % kY, i = cube / (kZ * kY);
    std::array<int, 8> nodes{};
    for (int c = 0; c < 8; c++) nodes[std::size_t(c)] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
    return nodes;
  }
};

/// Gradients of the eight shape functions of a cube at one of its 2 × 2 × 2 points.
std::array<Vec3d, 8> shape_gradients(int point) {
  const double near = 0.5 * (1 - std::sqrt(1.0 / 3)), far = 1 - near;
  std::array<Vec3d, 8> gradients{};
  for (int c = 0; c < 8; c++) {
    double value[3], slope[3];
    for (int axis = 0; axis < 3; axis++) {
      const bool upper = c >> axis & 1;
      value[axis] = upper == bool(point >> axis & 1) ? far : near;
      slope[axis] = (upper ? 1 : -1) / CubeMesh::kEdge;
    }
    gradients[std::size_t(c)] = {slope[0] * value[1] * value[2], value[0] * slope[1] * value[2],
                                 value[0] * value[1] * slope[2]};
  }
  return gradients;
}

/// A law without its volume term, and κ.
struct IsochoricLaw {
  SolidEnergy energy;
  LawModuli moduli;  // bulk = 0
  double bulk;
};

double& entry(Mat3d& m, int n) { return m.column[n / 3][n % 3]; }
double entry(const Mat3d& m, int n) { return m.column[n / 3][n % 3]; }
Mat3d cofactor_of(const Mat3d& f) {
  const auto& [x, y, z] = f.column;
  return {{cross(y, z), cross(z, x), cross(x, y)}};
}
double volume_ratio(const Mat3d& f) { return dot(f.column[0], cross(f.column[1], f.column[2])); }

/// ∂W/∂F + p cof F, with a pressure p.
Mat3d stress_at(const IsochoricLaw& law, double pressure, const Mat3d& f) {
  constexpr double kStep = 1e-5;
  Mat3d stress;
  const Mat3d cofactor = cofactor_of(f);
  for (int n = 0; n < 9; n++) {
    Mat3d up = f, down = f;
    entry(up, n) += kStep, entry(down, n) -= kStep;
    entry(stress, n) =
        (law_energy(law.energy, up, law.moduli) - law_energy(law.energy, down, law.moduli)) / (2 * kStep) +
        pressure * entry(cofactor, n);
  }
  return stress;
}

/// One cube at a displacement: F at its points, mean J, gradient of that mean by the 24 unknowns.
struct StrainedCube {
  std::array<int, 8> nodes;
  std::array<std::array<Vec3d, 8>, 8> gradients;
  std::array<Mat3d, 8> f;
  double mean = 0;
  std::array<double, 24> mean_gradient{};

  StrainedCube(int cube, const std::vector<double>& u) : nodes(CubeMesh::corners(cube)) {
    for (std::size_t g = 0; g < 8; g++) {
      gradients[g] = shape_gradients(int(g));
      f[g] = {{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
      for (std::size_t c = 0; c < 8; c++)
        for (int row = 0; row < 3; row++)
          for (int column = 0; column < 3; column++)
            f[g].column[column][row] += u[std::size_t(3 * nodes[c] + row)] * gradients[g][c][column];
      mean += volume_ratio(f[g]) / 8;
      const Mat3d cofactor = cofactor_of(f[g]);
      for (std::size_t c = 0; c < 8; c++) {
        const Vec3d force = cofactor * gradients[g][c];
        for (int row = 0; row < 3; row++) mean_gradient[3 * c + std::size_t(row)] += force[row] / 8;
      }
    }
  }
};

/// Forces and tangent of the block; the tangent holds kBand entries on each side of its diagonal.
struct CubeSystem {
  static constexpr int kWidth = 2 * CubeMesh::kBand + 1;
  std::vector<double> force = std::vector<double>(CubeMesh::kUnknowns);
  std::vector<double> tangent = std::vector<double>(std::size_t(CubeMesh::kUnknowns) * kWidth);

  double& at(int row, int column) {
    return tangent[std::size_t(row) * kWidth + std::size_t(column - row + CubeMesh::kBand)];
  }

  CubeSystem(const IsochoricLaw& law, const std::vector<double>& u) {
    constexpr double kVolume = CubeMesh::kEdge * CubeMesh::kEdge * CubeMesh::kEdge, kStep = 1e-5;
    for (int cube = 0; cube < CubeMesh::kCubes; cube++) {
      const StrainedCube e(cube, u);
      const double pressure = law.bulk * (e.mean - 1);
      const auto unknown = [&](std::size_t a) { return 3 * e.nodes[a / 3] + int(a % 3); };
      for (std::size_t a = 0; a < 24; a++)
        for (std::size_t b = 0; b < 24; b++)
          at(unknown(a), unknown(b)) += kVolume * law.bulk * e.mean_gradient[a] * e.mean_gradient[b];
      for (std::size_t g = 0; g < 8; g++) {
        const Mat3d stress = stress_at(law, pressure, e.f[g]);
        for (std::size_t c = 0; c < 8; c++) {
          const Vec3d at_corner = stress * e.gradients[g][c] * (kVolume / 8);
          for (int row = 0; row < 3; row++) force[std::size_t(3 * e.nodes[c] + row)] += at_corner[row];
        }
        for (int n = 0; n < 9; n++) {
          Mat3d moved = e.f[g];
          entry(moved, n) += kStep;
          const Mat3d next = stress_at(law, pressure, moved);
          Mat3d slope;
          for (int m = 0; m < 9; m++)
            entry(slope, m) = (entry(next, m) - entry(stress, m)) / kStep * (kVolume / 8);
          for (std::size_t b = 0; b < 8; b++)
            for (std::size_t c = 0; c < 8; c++) {
              const Vec3d column = slope * e.gradients[g][c] * e.gradients[g][b][n / 3];
              for (int row = 0; row < 3; row++)
                at(3 * e.nodes[c] + row, 3 * e.nodes[b] + n % 3) += column[row];
            }
        }
      }
    }
  }
  /// Gives the step of some unknowns: their rows become those of the identity.
  void prescribe(const std::vector<bool>& held, const std::vector<double>& step) {
    for (int a = 0; a < CubeMesh::kUnknowns; a++) {
      const int first = std::max(0, a - CubeMesh::kBand),
                end = std::min(CubeMesh::kUnknowns, a + CubeMesh::kBand + 1);
      for (int b = first; b < end; b++) {
        if (!held[std::size_t(a)] && held[std::size_t(b)])
          force[std::size_t(a)] += at(a, b) * step[std::size_t(b)];
        if (held[std::size_t(a)] || held[std::size_t(b)]) at(a, b) = a == b;
      }
      if (held[std::size_t(a)]) force[std::size_t(a)] = -step[std::size_t(a)];
    }
  }
  /// Newton step −K⁻¹ f, by elimination within the band.
  std::vector<double> step() {
    std::vector<double> x(force.size());
    for (std::size_t a = 0; a < x.size(); a++) x[a] = -force[a];
    const auto last = [](int a) { return std::min(CubeMesh::kUnknowns - 1, a + CubeMesh::kBand); };
    for (int a = 0; a < CubeMesh::kUnknowns; a++)
      for (int row = a + 1; row <= last(a); row++) {
        const double factor = at(row, a) / at(a, a);
        if (factor == 0) continue;
        for (int b = a; b <= last(a); b++) at(row, b) -= factor * at(a, b);
        x[std::size_t(row)] -= factor * x[std::size_t(a)];
      }
    for (int a = CubeMesh::kUnknowns - 1; a >= 0; a--) {
      for (int b = a + 1; b <= last(a); b++) x[std::size_t(a)] -= at(a, b) * x[std::size_t(b)];
      x[std::size_t(a)] /= at(a, a);
    }
    return x;
  }
};

/// Displacement of the block whose ends are clamped, one of which moves along x by the half length.
std::vector<double> stretch_block(const IsochoricLaw& law) {
  constexpr int kLoadSteps = 20, kIterations = 12;
  constexpr double kMoved = 1, kTolerance = 1e-8;
  std::vector<double> u(CubeMesh::kUnknowns), prescribed(u.size());
  std::vector<bool> held(u.size());
  const std::size_t end = 3 * std::size_t(CubeMesh::node(1, 0, 0));  // unknowns of one end
  for (std::size_t a = 0; a < end; a++) {
    held[a] = held[u.size() - end + a] = true;
    if (a % 3 == 0) prescribed[u.size() - end + a] = kMoved / kLoadSteps;
  }
  const std::vector<double> none(u.size());
  for (int load = 0; load < kLoadSteps; load++)
    for (int iteration = 0; iteration < kIterations; iteration++) {
      CubeSystem system(law, u);
      system.prescribe(held, iteration == 0 ? prescribed : none);
      const std::vector<double> step = system.step();
      double largest = 0;
      for (std::size_t a = 0; a < u.size(); a++)
        u[a] += step[a], largest = std::max(largest, std::abs(step[a]));
      if (largest < kTolerance) break;
    }
  return u;
}

/// Norm of the free displacements of a block that is stretched.
double displacement_norm(const IsochoricLaw& law) {
  const std::vector<double> u = stretch_block(law);
  const std::size_t end = 3 * std::size_t(CubeMesh::node(1, 0, 0));
  double sum = 0;
  for (std::size_t a = end; a < u.size() - end; a++) sum += u[a] * u[a];
  return std::sqrt(sum);
}

/// Norm of the free displacements of a bar of 2 × 1 × 1 that slides on three planes and stretches to 1.25, at
/// the 11 × 6 × 6 nodes of a mesh whose layers grow by 1.2 along the bar. Its deformation is uniform, so that
/// the law at a point solves it: the stretch across is the one of least energy.
double graded_bar_norm(SolidEnergy energy, const LawModuli& moduli) {
  constexpr double kStretch = 1.25, kLength = 2, kSide = 1, kGrowth = 1.2, kStep = 1e-4;
  constexpr int kLayers = 10, kAcross = 5, kIterations = 20;
  const auto at = [&](double across) {
    return law_energy(energy, {{Vec3d{kStretch, 0, 0}, Vec3d{0, across, 0}, Vec3d{0, 0, across}}}, moduli);
  };
  double across = 1 / std::sqrt(kStretch);
  for (int n = 0; n < kIterations; n++) {
    const double up = at(across + kStep), down = at(across - kStep);
    across -= kStep / 2 * (up - down) / (up - 2 * at(across) + down);
  }
  // nodes between the ends move along; all nodes off the planes move across, along y and along z
  double sum = 0, position = 0, layer = kLength * (kGrowth - 1) / (std::pow(kGrowth, kLayers) - 1);
  for (int n = 1; n < kLayers; n++, layer *= kGrowth) {
    position += layer;
    sum += std::pow((kStretch - 1) * position, 2) * (kAcross + 1) * (kAcross + 1);
  }
  for (int n = 1; n <= kAcross; n++)
    sum += 2 * std::pow((across - 1) * kSide * n / kAcross, 2) * (kAcross + 1) * (kLayers + 1);
  return std::sqrt(sum);
}

}  // namespace

void add_febio(MeasuredResult& result) {
  struct Problem {
    const char *name, *law;
    IsochoricLaw values;
    double stored;
  };
  // FEBio's c1 and m1 of Ogden's law, c1 of Mooney and Rivlin's: µ = c1/2, µ = 2 c1
  const Problem problems[] = {
      {"ma01", "Ogden", {SolidEnergy::kOgden, {0.658 / 2, 0, 6.83}, 1000}, 7.73149507271},
      {"mi09", "exponential b = 0", {SolidEnergy::kExponential, {2, 0, 0}, 1000}, 7.75904447374}};
  for (const Problem& p : problems)
    result.rows.push_back(band_row(
        fmt::format("FEBio {}, {}, clamped block stretched to 1.5: norm of displacements", p.name, p.law),
        kFebioSource, "1", p.stored, 0.01 * p.stored, displacement_norm(p.values)));
  constexpr double kStored = 4.17586115304;
  result.rows.push_back(band_row(
      "FEBio mi27, exponential b = 0, graded bar stretched to 1.25: norm of displacements", kFebioSource, "1",
      kStored, 0.01 * kStored, graded_bar_norm(SolidEnergy::kExponential, {2, 100, 0})));
}

}  // namespace turgor
