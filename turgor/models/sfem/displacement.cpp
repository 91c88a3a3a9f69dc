#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::sfem {

namespace {

constexpr std::size_t kRows =
    1536;  // rows of the result at a time, so that they stay in the first-level cache

/// y += A f for one vertex: three columns of `stride` rows each, from row `begin` on.
template <class T>
void add_columns(const T* columns, std::size_t stride, std::size_t begin, std::size_t count, const double* f,
                 float* y) {
  const T *a = columns + begin, *b = a + stride, *c = b + stride;
  const T fx = T(f[0]), fy = T(f[1]), fz = T(f[2]);
  TURGOR_LANES
  for (std::size_t i = 0; i < count; i++) y[i] += float(a[i] * fx + b[i] * fy + c[i] * fz);
}

}  // namespace

void surface_displacements(const Exec& exec, const Model& model, std::span<const int> vertices,
                           std::span<const double> forces, std::span<float> out) {
  const Green& green = model.green;
  const std::size_t rows = 3 * green.surface_count, stride = 3 * green.nodes.size();
  TURGOR_ASSERT(out.size() == rows && forces.size() == 3 * vertices.size(), "three numbers a vertex");
  TURGOR_CHECK(all_indices(vertices, green.slot.size()), "forces act on vertices of the body");
  exec.run_ranges((rows + kRows - 1) / kRows, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t tile = first; tile < last; tile++) {
      // a tile of rows
      const std::size_t begin = tile * kRows, count = std::min(kRows, rows - begin);
      std::fill_n(out.data() + begin, count, 0.0f);
      // add the columns of loaded vertices, from any store
      for (std::size_t v = 0; v < vertices.size(); v++) {
        const int slot = green.slot[std::size_t(vertices[v])];
        const double* f = &forces[3 * v];
        if (slot < 0 || (f[0] == 0 && f[1] == 0 && f[2] == 0)) continue;
        const std::size_t at = 3 * std::size_t(slot) * stride;
        if (!green.single_values.empty())
          add_columns(&green.single_values[at], stride, begin, count, f, out.data() + begin);
        else if (!green.double_values.empty())
          add_columns(&green.double_values[at], stride, begin, count, f, out.data() + begin);
        else
          add_columns(green.columns[std::size_t(slot)].data(), stride, begin, count, f, out.data() + begin);
      }
    }
  });
}

}  // namespace turgor::sfem
