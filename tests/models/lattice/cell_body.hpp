// Bodies of cubic cells at small displacements, solved directly with any element matrix on the corners of a
// cell, for any set of cells. They are the reference for the lattice's law.
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <functional>
#include <map>
#include <tuple>
#include <vector>

#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::lattice {

using CellMatrix = Eigen::Matrix<double, 24, 24>;  // by corner, then axis

/// Stiffness of the law at rest, by differences of its energy; E = 1 [m].
inline CellMatrix solid_matrix(double step, double poisson) {
  const auto energy = [&](int i, int j, double di, double dj) {
    Vec3d u[kCellCorners];
    u[i / 3][i % 3] += di, u[j / 3][j % 3] += dj;
    return cell_energy(u, Vec3{Real(step), Real(step), Real(step)}, poisson);
  };
  const double d = 1e-4 * step;
  CellMatrix k;
  for (int i = 0; i < 24; i++)
    for (int j = 0; j < 24; j++)
      k(i, j) = (energy(i, j, d, d) - energy(i, j, d, -d) - energy(i, j, -d, d) + energy(i, j, -d, -d)) /
                (4 * d * d);
  return k;
}

/// Linear tetrahedra: Kuhn's six around one diagonal, or the mean over all four diagonals; E = 1 [m].
inline CellMatrix kuhn_matrix(double step, double poisson, bool mirrored) {
  CellMatrix matrix = CellMatrix::Zero();
  const int mirrors = mirrored ? 4 : 1;
  for (int mirror = 0; mirror < mirrors; mirror++)
    for (const auto& tet : kKuhnTets) {
      int corner[4];
      std::array<Vec3d, 4> x;
      for (std::size_t c = 0; c < 4; c++) {
        corner[c] = (tet[c].x + 2 * tet[c].y + 4 * tet[c].z) ^ mirror;
        x[c] = Vec3d(cell_corner(corner[c])) * step;
      }
      if (dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) < 0)
        std::swap(x[1], x[2]), std::swap(corner[1], corner[2]);
      std::array<double, 144> k{};
      sfem::tet_stiffness(x, sfem::Material{1, poisson}, k);
      for (int i = 0; i < 12; i++)
        for (int j = 0; j < 12; j++)
          matrix(3 * corner[i / 3] + i % 3, 3 * corner[j / 3] + j % 3) +=
              k[std::size_t(12 * i + j)] / mirrors;
    }
  return matrix;
}

/// A set of cells of side `step`.
struct CellBody {
  double step = 1;
  std::vector<Int3> cells;   // lowest corners
  std::vector<char> is_end;  // whether the corners of the cell are prescribed
};

/// Energies of the body for displacement fields prescribed at the end cells' corners and at nodes with
/// `is_held` [J for E = 1 Pa].
inline std::vector<double> held_energies(
    const CellBody& body, const CellMatrix& matrix, const std::vector<std::function<Vec3d(Vec3d)>>& moved,
    const std::function<bool(Vec3d)>& is_held = [](Vec3d) { return false; }) {
  std::map<std::tuple<int, int, int>, int> index;
  std::vector<Vec3d> x;
  std::vector<char> held;
  const auto node = [&](Int3 p) {
    const auto [at, is_new] = index.try_emplace({p.x, p.y, p.z}, int(x.size()));
    if (is_new) x.push_back(Vec3d(p) * body.step), held.push_back(is_held(x.back()));
    return at->second;
  };
  std::vector<std::array<int, 8>> cells;
  for (std::size_t c = 0; c < body.cells.size(); c++) {
    std::array<int, 8>& corners = cells.emplace_back();
    for (int n = 0; n < 8; n++) {
      corners[std::size_t(n)] = node(body.cells[c] + cell_corner(n));
      held[std::size_t(corners[std::size_t(n)])] |= body.is_end[c];
    }
  }
  std::vector<int> row(x.size(), -1);
  int count = 0;
  for (std::size_t n = 0; n < x.size(); n++)
    if (!held[n]) row[n] = 3 * count++;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(3 * count, Eigen::Index(moved.size()));
  const auto prescribed = [&](std::size_t field, int n) {
    return held[std::size_t(n)] ? moved[field](x[std::size_t(n)]) : Vec3d{};
  };
  for (const auto& corners : cells)
    for (int i = 0; i < 24; i++) {
      const int a = row[std::size_t(corners[std::size_t(i / 3)])];
      if (a < 0) continue;
      for (int j = 0; j < 24; j++) {
        const int other = corners[std::size_t(j / 3)], b = row[std::size_t(other)];
        if (b >= 0) entries.emplace_back(a + i % 3, b + j % 3, matrix(i, j));
        for (std::size_t f = 0; f < moved.size() && b < 0; f++)
          load(a + i % 3, Eigen::Index(f)) -= matrix(i, j) * prescribed(f, other)[j % 3];
      }
    }
  Eigen::SparseMatrix<double> k(3 * count, 3 * count);
  k.setFromTriplets(entries.begin(), entries.end());
  const Eigen::MatrixXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(k).solve(load);
  std::vector<double> energies;
  for (std::size_t f = 0; f < moved.size(); f++) {
    double sum = 0;
    for (const auto& corners : cells) {
      Eigen::Matrix<double, 24, 1> v;
      for (int i = 0; i < 24; i++) {
        const int n = corners[std::size_t(i / 3)], r = row[std::size_t(n)];
        v[i] = r < 0 ? prescribed(f, n)[i % 3] : u(r + i % 3, Eigen::Index(f));
      }
      sum += 0.5 * v.dot(matrix * v);
    }
    energies.push_back(sum);
  }
  return energies;
}

}  // namespace turgor::lattice
