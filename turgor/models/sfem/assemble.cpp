// K row by row: each row gathers what the elements and nodal volumes around its vertex add to it, always in
// the same order.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

/// Row i of the pattern: every vertex that shares a list with vertex i.
void make_pattern(const Exec& exec, const Lists& lists, const Lists& around, BlockMatrix& k) {
  const std::size_t rows = around.count();
  std::vector<std::size_t> most{0};  // where a row may start when nothing is shared
  for (std::size_t i = 0; i < rows; i++) {
    std::size_t length = 0;
    for (const int l : around[i]) length += lists[std::size_t(l)].size();
    most.push_back(most.back() + length);
  }
  std::vector<int> columns(most.back());
  std::vector<std::size_t> length(rows);
  parallel_for(
      exec, rows,
      [&](std::size_t i) {
        const auto begin = columns.begin() + std::ptrdiff_t(most[i]);
        auto end = begin;
        for (const int l : around[i])
          end = std::copy(lists[std::size_t(l)].begin(), lists[std::size_t(l)].end(), end);
        std::sort(begin, end);
        length[i] = std::size_t(std::unique(begin, end) - begin);
      },
      64);
  k.row_begin.assign(1, 0);
  for (std::size_t i = 0; i < rows; i++) k.row_begin.push_back(k.row_begin.back() + length[i]);
  k.column.resize(k.row_begin.back());
  for (std::size_t i = 0; i < rows; i++)
    std::copy_n(columns.begin() + std::ptrdiff_t(most[i]), length[i],
                k.column.begin() + std::ptrdiff_t(k.row_begin[i]));
  TURGOR_CHECK(is_csr(k.row_begin, k.column.size()), "the rows cover all blocks");
  k.value.assign(9 * k.column.size(), 0);
}

double* block_of(BlockMatrix& k, std::size_t row, int column) {
  const auto begin = k.column.begin() + std::ptrdiff_t(k.row_begin[row]);
  const auto end = k.column.begin() + std::ptrdiff_t(k.row_begin[row + 1]);
  TURGOR_CHECK(std::binary_search(begin, end, column), "the block belongs to the pattern");
  return &k.value[9 * std::size_t(std::lower_bound(begin, end, column) - k.column.begin())];
}

std::size_t place_in(std::span<const int> list, int number) {
  return std::size_t(std::find(list.begin(), list.end(), number) - list.begin());
}

void add_elements(std::size_t row, const Lists& elements, std::span<const int> around,
                  const std::vector<double>& matrices, BlockMatrix& k) {
  for (const int e : around) {
    const std::span<const int> vertices = elements[std::size_t(e)];
    const std::size_t n = 3 * vertices.size(), a = place_in(vertices, int(row));
    const double* matrix = &matrices[std::size_t(e) * n * n];
    for (std::size_t b = 0; b < vertices.size(); b++) {
      double* block = block_of(k, row, vertices[b]);
      for (std::size_t i = 0; i < 9; i++) block[i] += matrix[(3 * a + i / 3) * n + 3 * b + i % 3];
    }
  }
}

void add_volumes(std::size_t row, const NodalVolumes& volumes, std::span<const int> around,
                 std::span<const Material> materials, BlockMatrix& k) {
  for (const int v : around) {
    const std::span<const int> vertices = volumes.vertices[std::size_t(v)];
    const Vec3d* gradient = &volumes.gradient[volumes.vertices.begin[std::size_t(v)]];
    const double bulk = moduli(materials[std::size_t(volumes.material[std::size_t(v)])]).bulk;
    const Vec3d own = gradient[place_in(vertices, int(row))];
    TURGOR_CHECK(volumes.volume[std::size_t(v)] > 0, "a nodal volume is not empty");
    const double scale = bulk / volumes.volume[std::size_t(v)];
    for (std::size_t b = 0; b < vertices.size(); b++) {
      double* block = block_of(k, row, vertices[b]);
      for (int i = 0; i < 9; i++) block[i] += scale * (own[i / 3] * gradient[b][i % 3]);
    }
  }
}

}  // namespace

std::vector<double> element_matrices(const Exec& exec, const SolidMesh& mesh,
                                     std::span<const Material> materials, std::span<const int> material,
                                     Formulation formulation) {
  TURGOR_CHECK(material.size() == element_count(mesh) && all_indices(material, materials.size()),
               "every element has one of the materials");
  const std::size_t n = 9 * std::size_t(mesh.corners) * std::size_t(mesh.corners);
  std::vector<double> all(element_count(mesh) * n);
  const auto corners = [&](std::size_t e, auto& x) {
    for (std::size_t c = 0; c < x.size(); c++) x[c] = mesh.vertices[std::size_t(element(mesh, e)[c])];
  };
  parallel_for(
      exec, element_count(mesh),
      [&](std::size_t e) {
        const Material& m = materials[std::size_t(material[e])];
        if (mesh.corners == 8) {
          std::array<Vec3d, 8> x;
          corners(e, x);
          hex_stiffness(x, m, formulation, std::span<double, 576>(all.data() + e * n, 576));
        } else if (mesh.corners == 10) {
          std::array<Vec3d, 10> x;
          corners(e, x);
          quadratic_stiffness(x, m, std::span<double, 900>(all.data() + e * n, 900));
        } else {
          std::array<Vec3d, 4> x;
          corners(e, x);
          const Moduli whole = moduli(m);
          const double bulk = formulation == Formulation::kAveraged ? 0 : whole.bulk;
          tet_stiffness(x, Moduli{bulk, whole.shear}, std::span<double, 144>(all.data() + e * n, 144));
        }
      },
      64);
  return all;
}

BlockMatrix assemble(const Exec& exec, const SolidMesh& mesh, std::span<const Material> materials,
                     std::span<const int> material, Formulation formulation) {
  const bool nodal = averages_nodes(mesh, formulation);
  const Lists elements = element_lists(mesh), around = holders(elements, mesh.vertices.size());
  const std::vector<double> matrices = element_matrices(exec, mesh, materials, material, formulation);
  const NodalVolumes volumes = nodal ? nodal_volumes(mesh, material) : NodalVolumes{};
  const Lists volumes_around = nodal ? holders(volumes.vertices, mesh.vertices.size()) : Lists{};

  // A nodal volume contains all vertices of its elements, so nodal volumes, where present, define the
  // pattern.
  BlockMatrix k;
  make_pattern(exec, nodal ? volumes.vertices : elements, nodal ? volumes_around : around, k);
  parallel_for(
      exec, mesh.vertices.size(),
      [&](std::size_t row) {
        add_elements(row, elements, around[row], matrices, k);
        if (nodal) add_volumes(row, volumes, volumes_around[row], materials, k);
      },
      64);
  return k;
}

}  // namespace turgor::sfem
