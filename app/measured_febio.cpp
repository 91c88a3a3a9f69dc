// Blocks of FEBio's test suite (measured_febio.hpp). Their meshes are coarse, so a result belongs to its
// elements. The laws are therefore solved in the same ones, hexahedra with a mean dilatation [Simo, Taylor,
// Pister 1985], or without it where FEBio's material has no such term. Stress and tangent are differences of
// a law's energy.
//
//   E(u) = Σ_e ( Σ_g V/8 W(F_g) + V κ/2 (J̄ − 1)² ),   J̄ = Σ_g det F_g/8
//
// FEBio has κ/2 (ln J̄)², which is the same for the small J̄ − 1 of these problems.
#include "app/measured_febio.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace turgor {

namespace {

using lattice::LawModuli, lattice::SolidEnergy;

/// Block of cubes; nodes count along z first, then y, then x.
struct CubeMesh {
  int x, y, z;
  double edge;

  int cubes() const { return x * y * z; }
  int unknowns() const { return 3 * node(x + 1, 0, 0); }
  /// Unknowns of one end.
  std::size_t end() const { return 3 * std::size_t(node(1, 0, 0)); }
  /// Largest difference of two unknowns of one cube.
  int band() const { return 3 * node(1, 1, 1) + 2; }

  int node(int i, int j, int k) const { return (i * (y + 1) + j) * (z + 1) + k; }
  std::array<int, 8> corners(int cube) const {
    const int k = cube % z, j = cube / z % y, i = cube / (z * y);
    std::array<int, 8> nodes{};
    for (int c = 0; c < 8; c++) nodes[std::size_t(c)] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
    return nodes;
  }
};

/// Gradients of the eight shape functions of a cube at one of its 2 × 2 × 2 points.
std::array<Vec3d, 8> shape_gradients(double edge, int point) {
  const double near = 0.5 * (1 - std::sqrt(1.0 / 3)), far = 1 - near;
  std::array<Vec3d, 8> gradients{};
  for (int c = 0; c < 8; c++) {
    double value[3], slope[3];
    for (int axis = 0; axis < 3; axis++) {
      const bool upper = c >> axis & 1;
      value[axis] = upper == bool(point >> axis & 1) ? far : near;
      slope[axis] = (upper ? 1 : -1) / edge;
    }
    gradients[std::size_t(c)] = {slope[0] * value[1] * value[2], value[0] * slope[1] * value[2],
                                 value[0] * value[1] * slope[2]};
  }
  return gradients;
}

/// A law, and the κ of the mean dilatation. The law has its own volume term instead where that κ is 0.
struct CubeLaw {
  SolidEnergy energy;
  LawModuli moduli;
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
Mat3d stress_at(const CubeLaw& law, double pressure, const Mat3d& f) {
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

  StrainedCube(const CubeMesh& mesh, int cube, const std::vector<double>& u) : nodes(mesh.corners(cube)) {
    for (std::size_t g = 0; g < 8; g++) {
      gradients[g] = shape_gradients(mesh.edge, int(g));
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

/// Forces and tangent of the block; the tangent holds `band` entries on each side of its diagonal.
struct CubeSystem {
  int unknowns, band;
  std::vector<double> force, tangent;

  double& at(int row, int column) {
    return tangent[std::size_t(row) * std::size_t(2 * band + 1) + std::size_t(column - row + band)];
  }

  CubeSystem(const CubeMesh& mesh, const CubeLaw& law, const std::vector<double>& u)
      : unknowns(mesh.unknowns()),
        band(mesh.band()),
        force(u.size()),
        tangent(u.size() * std::size_t(2 * band + 1)) {
    constexpr double kStep = 1e-5;
    const double volume = mesh.edge * mesh.edge * mesh.edge;
    for (int cube = 0; cube < mesh.cubes(); cube++) {
      const StrainedCube e(mesh, cube, u);
      const double pressure = law.bulk * (e.mean - 1);
      const auto unknown = [&](std::size_t a) { return 3 * e.nodes[a / 3] + int(a % 3); };
      for (std::size_t a = 0; a < 24; a++)
        for (std::size_t b = 0; b < 24; b++)
          at(unknown(a), unknown(b)) += volume * law.bulk * e.mean_gradient[a] * e.mean_gradient[b];
      for (std::size_t g = 0; g < 8; g++) {
        const Mat3d stress = stress_at(law, pressure, e.f[g]);
        for (std::size_t c = 0; c < 8; c++) {
          const Vec3d at_corner = stress * e.gradients[g][c] * (volume / 8);
          for (int row = 0; row < 3; row++) force[std::size_t(3 * e.nodes[c] + row)] += at_corner[row];
        }
        for (int n = 0; n < 9; n++) {
          Mat3d moved = e.f[g];
          entry(moved, n) += kStep;
          const Mat3d next = stress_at(law, pressure, moved);
          Mat3d slope;
          for (int m = 0; m < 9; m++)
            entry(slope, m) = (entry(next, m) - entry(stress, m)) / kStep * (volume / 8);
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
    for (int a = 0; a < unknowns; a++) {
      const int first = std::max(0, a - band), end = std::min(unknowns, a + band + 1);
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
    const auto last = [&](int a) { return std::min(unknowns - 1, a + band); };
    for (int a = 0; a < unknowns; a++)
      for (int row = a + 1; row <= last(a); row++) {
        const double factor = at(row, a) / at(a, a);
        if (factor == 0) continue;
        for (int b = a; b <= last(a); b++) at(row, b) -= factor * at(a, b);
        x[std::size_t(row)] -= factor * x[std::size_t(a)];
      }
    for (int a = unknowns - 1; a >= 0; a--) {
      for (int b = a + 1; b <= last(a); b++) x[std::size_t(a)] -= at(a, b) * x[std::size_t(b)];
      x[std::size_t(a)] /= at(a, a);
    }
    return x;
  }
};

/// Unknowns that are held, their displacement, and forces on the others; both are applied in steps.
struct CubeLoad {
  std::vector<bool> held;
  std::vector<double> displacement, force;
  int steps;
};

/// Displacement of a block in equilibrium with its load.
std::vector<double> load_block(const CubeMesh& mesh, const CubeLaw& law, const CubeLoad& load) {
  constexpr int kIterations = 12;
  constexpr double kTolerance = 1e-8;
  std::vector<double> u(load.held.size()), first(u.size());
  for (std::size_t a = 0; a < u.size(); a++) first[a] = load.displacement[a] / load.steps;
  const std::vector<double> none(u.size());
  for (int n = 1; n <= load.steps; n++)
    for (int iteration = 0; iteration < kIterations; iteration++) {
      CubeSystem system(mesh, law, u);
      for (std::size_t a = 0; a < u.size(); a++) system.force[a] -= load.force[a] * n / load.steps;
      system.prescribe(load.held, iteration == 0 ? first : none);
      const std::vector<double> step = system.step();
      double largest = 0;
      for (std::size_t a = 0; a < u.size(); a++)
        u[a] += step[a], largest = std::max(largest, std::abs(step[a]));
      if (largest < kTolerance) break;
    }
  return u;
}
/// Norm of the displacements that are not held.
double free_norm(const CubeMesh& mesh, const CubeLaw& law, const CubeLoad& load) {
  const std::vector<double> u = load_block(mesh, law, load);
  double sum = 0;
  for (std::size_t a = 0; a < u.size(); a++)
    if (!load.held[a]) sum += u[a] * u[a];
  return std::sqrt(sum);
}
/// Load whose ends are clamped.
CubeLoad clamped_ends(const CubeMesh& mesh, int steps) {
  const std::size_t size = std::size_t(mesh.unknowns());
  CubeLoad load{std::vector<bool>(size), std::vector<double>(size), std::vector<double>(size), steps};
  for (std::size_t a = 0; a < mesh.end(); a++) load.held[a] = load.held[size - 1 - a] = true;
  return load;
}

/// Norm of a block of 2 × 1 × 1, one clamped end of which moves along x by half the length.
double stretched_norm(const CubeLaw& law) {
  const CubeMesh mesh{8, 4, 4, 0.25};
  CubeLoad load = clamped_ends(mesh, 20);
  for (std::size_t a = load.held.size() - mesh.end(); a < load.held.size(); a += 3) load.displacement[a] = 1;
  return free_norm(mesh, law, load);
}
/// Norm of a block of 2 × 1 × 1 under a pressure on an end that moves along x only.
double pressed_norm(const CubeLaw& law) {
  const CubeMesh mesh{10, 5, 5, 0.2};
  constexpr double kPressure = 0.005;
  CubeLoad load = clamped_ends(mesh, 1);
  const auto along = [&](int j, int k) { return std::size_t(3 * mesh.node(mesh.x, j, k)); };
  for (int j = 0; j <= mesh.y; j++)
    for (int k = 0; k <= mesh.z; k++) load.held[along(j, k)] = false;
  for (int j = 0; j < mesh.y; j++)
    for (int k = 0; k < mesh.z; k++)
      for (int c = 0; c < 4; c++)
        load.force[along(j + (c & 1), k + (c >> 1))] -= kPressure * mesh.edge * mesh.edge / 4;
  return free_norm(mesh, law, load);
}

}  // namespace

void add_febio(MeasuredResult& result) {
  const auto add = [&](const char* name, double stored, double found) {
    result.rows.push_back(febio_row(name, stored, found));
  };
  // FEBio's c1 of Ogden's law, c1 of Mooney and Rivlin's: µ = c1/2, µ = 2 c1
  add("ma01, Ogden, clamped block stretched to 1.5", 7.73149507271,
      stretched_norm({SolidEnergy::kOgden, {0.658 / 2, 0, 6.83}, 1000}));
  add("mi09, exponential b = 0, clamped block stretched to 1.5", 7.75904447374,
      stretched_norm({SolidEnergy::kExponential, {2, 0, 0}, 1000}));
  // at t = 1, 100 times the time of its pair, the viscous block is as soft as without the pair
  add("ma06, neo-Hookean, relaxed block under a pressure", 0.110343152075,
      pressed_norm({SolidEnergy::kNeoHookean, febio_neo_hookean(0.4), 0}));
  add_uniform_febio(result);
}

}  // namespace turgor
