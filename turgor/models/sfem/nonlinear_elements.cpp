#include "turgor/models/sfem/nonlinear_elements.hpp"

#include <algorithm>
#include <array>

#include "turgor/core/assert.hpp"

namespace turgor::sfem {

namespace {

constexpr std::size_t kMostNodes = 10;

/// One element: displacement of its nodes, forces and stiffness, 3×3 blocks row by row.
struct ElementSystem {
  std::array<Vec3d, kMostNodes> u;
  std::array<Vec3d, kMostNodes> force;
  std::array<std::array<double, 9>, kMostNodes * kMostNodes> block;  // (a, b) at a · nodes + b, b ≥ a
};

/// Deformation gradient from the gradients of an element's functions.
Mat3d deformation(const ElementSystem& element, std::size_t nodes, const double* g) {
  Mat3d f;
  for (std::size_t a = 0; a < nodes; a++)
    for (int axis = 0; axis < 3; axis++) f.column[axis] += element.u[a] * g[3 * a + std::size_t(axis)];
  return f;
}

void gather(const NonlinearPatch& patch, std::size_t e, ElementSystem& element) {
  const auto nodes = std::size_t(patch.element_nodes);
  for (std::size_t c = 0; c < nodes; c++) {
    const auto n = std::size_t(patch.corners[e * nodes + c]);
    Vec3d u;
    for (std::size_t w = patch.begin[n]; w < patch.begin[n + 1]; w++) {
      const double* of_node = &patch.u[3 * std::size_t(patch.weighted[w].node)];
      u += patch.weighted[w].weight * Vec3d{of_node[0], of_node[1], of_node[2]};
    }
    element.u[c] = u;
  }
}

/// Adds one Gauss point: forces ∫ P g dV and blocks ∫ gᵀ (∂P/∂F) g dV.
void add_gauss_point(const LawStress& law, std::size_t nodes, const double* g, double volume,
                     ElementSystem& element) {
  for (std::size_t a = 0; a < nodes; a++)
    for (std::size_t axis = 0; axis < 3; axis++)
      for (int i = 0; i < 3; i++)
        element.force[a][i] += volume * g[3 * a + axis] * law.stress[3 * axis + std::size_t(i)];
  for (std::size_t b = 0; b < nodes; b++) {
    // (∂P/∂F) g of node b: 9 × 3
    std::array<double, 27> slope{};
    for (std::size_t row = 0; row < 9; row++)
      for (std::size_t k = 0; k < 3; k++) {
        double sum = 0;
        for (std::size_t axis = 0; axis < 3; axis++)
          sum += law.tangent[9 * row + 3 * axis + k] * g[3 * b + axis];
        slope[3 * row + k] = volume * sum;
      }
    for (std::size_t a = 0; a <= b; a++) {
      std::array<double, 9>& block = element.block[a * nodes + b];
      for (std::size_t i = 0; i < 3; i++)
        for (std::size_t k = 0; k < 3; k++)
          for (std::size_t axis = 0; axis < 3; axis++)
            block[3 * i + k] += g[3 * a + axis] * slope[3 * (3 * axis + i) + k];
    }
  }
}

double* block_at(BlockMatrix& k, int row, int column) {
  const auto begin = k.column.begin() + std::ptrdiff_t(k.row_begin[std::size_t(row)]),
             end = k.column.begin() + std::ptrdiff_t(k.row_begin[std::size_t(row) + 1]);
  const auto at = std::lower_bound(begin, end, column);
  TURGOR_CHECK(at != end && *at == column, "the pattern of the tangent has all blocks of its elements");
  return &k.value[9 * std::size_t(at - k.column.begin())];
}

/// Adds an element's blocks to the unknown nodes that move its nodes.
void scatter(NonlinearPatch& patch, std::size_t e, const ElementSystem& element,
             std::vector<double>* forces) {
  const auto nodes = std::size_t(patch.element_nodes);
  const auto node = [&](std::size_t c) { return std::size_t(patch.corners[e * nodes + c]); };
  for (std::size_t a = 0; a < nodes; a++)
    for (std::size_t w = patch.begin[node(a)]; w < patch.begin[node(a) + 1]; w++) {
      const WeightedNode& row = patch.weighted[w];
      if (forces)
        for (int i = 0; i < 3; i++)
          (*forces)[3 * std::size_t(row.node) + std::size_t(i)] += row.weight * element.force[a][i];
      for (std::size_t b = 0; b < nodes; b++) {
        const bool swap = b < a;
        const std::array<double, 9>& block = element.block[swap ? b * nodes + a : a * nodes + b];
        for (std::size_t v = patch.begin[node(b)]; v < patch.begin[node(b) + 1]; v++) {
          const WeightedNode& column = patch.weighted[v];
          double* to = block_at(patch.tangent, row.node, column.node);
          const double weight = row.weight * column.weight;
          for (std::size_t k = 0; k < 9; k++) to[k] += weight * block[swap ? k % 3 * 3 + k / 3 : k];
        }
      }
    }
}

/// S u at the border's unknown nodes.
std::vector<double> exterior_forces(const NonlinearPatch& patch) {
  const std::size_t n = 3 * patch.rim.size();
  std::vector<double> result(n);
  for (std::size_t b = 0; b < n; b++) {
    const auto vertex = std::size_t(patch.rim[b / 3]);
    const double u = patch.u[3 * std::size_t(patch.coarse_node[vertex]) + b % 3];
    for (std::size_t a = 0; a < n; a++) result[a] += patch.exterior[b * n + a] * u;
  }
  return result;
}

std::size_t unknown_of_rim(const NonlinearPatch& patch, std::size_t i) {
  return std::size_t(patch.coarse_node[std::size_t(patch.rim[i])]);
}

void add_exterior(NonlinearPatch& patch, std::vector<double>* forces) {
  const std::size_t count = patch.rim.size(), n = 3 * count;
  for (std::size_t a = 0; a < count; a++)
    for (std::size_t b = 0; b < count; b++) {
      double* to = block_at(patch.tangent, int(unknown_of_rim(patch, a)), int(unknown_of_rim(patch, b)));
      for (std::size_t i = 0; i < 3; i++)
        for (std::size_t k = 0; k < 3; k++) to[3 * i + k] += patch.exterior[(3 * b + k) * n + 3 * a + i];
    }
  if (!forces) return;
  const std::vector<double> of_rim = exterior_forces(patch);
  for (std::size_t a = 0; a < n; a++) (*forces)[3 * unknown_of_rim(patch, a / 3) + a % 3] += of_rim[a];
}

}  // namespace

NonlinearReport assemble_nonlinear(NonlinearPatch& patch, std::vector<double>* forces) {
  const auto nodes = std::size_t(patch.element_nodes);
  const std::size_t points = patch.volume.size() / std::max<std::size_t>(1, patch.moduli.size());
  std::fill(patch.tangent.value.begin(), patch.tangent.value.end(), 0);
  if (forces) std::fill(forces->begin(), forces->end(), 0);
  NonlinearReport report;
  ElementSystem element;
  for (std::size_t e = 0; e < patch.moduli.size(); e++) {
    gather(patch, e, element);
    element.force.fill({});
    std::fill_n(element.block.begin(), nodes * nodes, std::array<double, 9>{});
    for (std::size_t p = e * points; p < (e + 1) * points; p++) {
      const double* g = &patch.gradient[3 * nodes * p];
      const Mat3d f = deformation(element, nodes, g);
      const double strain = largest_strain(f);
      report.strain = std::max(report.strain, strain);
      if (patch.at_border[e]) report.border_strain = std::max(report.border_strain, strain);
      add_gauss_point(law_stress(f, patch.moduli[e], patch.law), nodes, g, patch.volume[p], element);
    }
    scatter(patch, e, element, forces);
  }
  add_exterior(patch, forces);
  return report;
}

double nonlinear_energy(const NonlinearPatch& patch, const std::vector<double>& f) {
  const auto nodes = std::size_t(patch.element_nodes);
  const std::size_t points = patch.volume.size() / std::max<std::size_t>(1, patch.moduli.size());
  double energy = 0;
  ElementSystem element;
  for (std::size_t e = 0; e < patch.moduli.size(); e++) {
    gather(patch, e, element);
    for (std::size_t p = e * points; p < (e + 1) * points; p++)
      energy += patch.volume[p] * law_energy(deformation(element, nodes, &patch.gradient[3 * nodes * p]),
                                             patch.moduli[e], patch.law);
  }
  const std::vector<double> of_rim = exterior_forces(patch);
  for (std::size_t a = 0; a < of_rim.size(); a++)
    energy += 0.5 * of_rim[a] * patch.u[3 * unknown_of_rim(patch, a / 3) + a % 3];
  for (std::size_t k = 0; k < f.size(); k++) energy -= f[k] * patch.u[k];
  return energy;
}

}  // namespace turgor::sfem
