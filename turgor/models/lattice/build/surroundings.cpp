#include "turgor/models/lattice/build/surroundings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/geometry/dilate.hpp"
#include "turgor/geometry/row_components.hpp"

namespace turgor::lattice {

namespace {

constexpr double kCell = 3e-3;   // side of a cell, if voxels are smaller [m]
constexpr double kLength = 0.1;  // of what does not belong to the body, at least [m]

using Mask = std::vector<std::uint8_t>;

/// Densest and least dense voxel of every cell against a bound.
struct PoolLayer {
  const CtPart& ct;
  DenseCells& cells;
  std::int16_t bound;
  int begin;

  void operator()(std::size_t at) const {
    const std::size_t layer = at + std::size_t(begin);
    const Int3 n = ct.whole.size, c = cells.cell;
    std::vector<std::int16_t> extremes(
        2 * static_cast<std::size_t>(n.x));  // of every column of this row of cells
    std::int16_t *least = extremes.data(), *most = least + n.x;
    const int k0 = int(layer) * c.z, k1 = std::min(k0 + c.z, n.z);
    for (int row = 0; row < cells.size.y; row++) {
      std::fill_n(least, n.x, std::int16_t(32767));
      std::fill_n(most, n.x, std::int16_t(-32768));
      for (int k = k0; k < k1; k++)
        for (int j = row * c.y; j < std::min((row + 1) * c.y, n.y); j++) {
          const std::int16_t* hu = ct.row(j, k);
          TURGOR_LANES
          for (int i = 0; i < n.x; i++)
            least[i] = std::min(least[i], hu[i]), most[i] = std::max(most[i], hu[i]);
        }
      const std::size_t first =
          (layer * std::size_t(cells.size.y) + std::size_t(row)) * std::size_t(cells.size.x);
      for (int i = 0; i < cells.size.x; i++) {
        const int low = i * c.x, high = std::min(low + c.x, n.x);
        cells.all[first + std::size_t(i)] = *std::min_element(least + low, least + high) >= bound;
        cells.any[first + std::size_t(i)] = *std::max_element(most + low, most + high) >= bound;
      }
    }
  }
};

/// The largest part of the cells that are dense throughout: any gap of a voxel ends it, and so does a sheet
/// thinner than a cell.
Mask core_of(const Mask& dense, Int3 size) {
  const RowComponents parts = row_components(dense, size);
  Mask core(dense.size());
  const int largest = parts.largest();
  for (const CellRun& run : parts.runs)
    if (run.part == largest)
      std::fill_n(core.begin() + ((std::ptrdiff_t(run.k) * size.y + run.j) * size.x + run.begin),
                  run.end - run.begin, std::uint8_t(1));
  return core;
}

/// First and last core cell along the two axes across the scan: what lies beyond is seen from a side of it.
class Silhouette {
 public:
  Silhouette(const Mask& core, Int3 size, int along) : size_(size), views_{(along + 1) % 3, (along + 2) % 3} {
    for (std::size_t v = 0; v < 2; v++) {
      Int3 lines = size;
      lines[views_[v]] = 1;
      extents_[v].assign(std::size_t(lines.x) * std::size_t(lines.y) * std::size_t(lines.z), kNone);
    }
    std::size_t n = 0;
    for (int k = 0; k < size.z; k++)
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++)
          if (core[n++])
            for (std::size_t v = 0; v < 2; v++) {
              Extent& e = extents_[v][line(v, {i, j, k})];
              const int at = Int3{i, j, k}[views_[v]];
              e.first = std::min(e.first, at), e.last = std::max(e.last, at);
            }
  }
  bool is_beyond(Int3 p) const {
    for (std::size_t v = 0; v < 2; v++)
      if (const Extent e = extents_[v][line(v, p)]; p[views_[v]] < e.first || p[views_[v]] > e.last)
        return true;
    return false;
  }

 private:
  struct Extent {
    int first, last;
  };
  static constexpr Extent kNone{1 << 30, -1};
  std::size_t line(std::size_t view, Int3 p) const {
    Int3 size = size_;
    size[views_[view]] = 1, p[views_[view]] = 0;
    return (std::size_t(p.z) * std::size_t(size.y) + std::size_t(p.y)) * std::size_t(size.x) +
           std::size_t(p.x);
  }
  Int3 size_;
  std::array<int, 2> views_;
  std::array<std::vector<Extent>, 2> extents_;
};

/// Which parts are long, and for the greater part beyond the body's silhouette.
std::vector<std::uint8_t> strange_parts(const RowComponents& parts, const Silhouette& silhouette,
                                        Vec3d side) {
  struct Seen {
    Int3 low{1 << 30, 1 << 30, 1 << 30}, high{};
    std::size_t beyond = 0;
  };
  std::vector<Seen> seen(parts.sizes.size());
  for (const CellRun& run : parts.runs) {
    Seen& s = seen[std::size_t(run.part)];
    s.low = min(s.low, Int3{run.begin, run.j, run.k});
    s.high = max(s.high, Int3{run.end, run.j + 1, run.k + 1});
    for (int i = run.begin; i < run.end; i++) s.beyond += silhouette.is_beyond({i, run.j, run.k});
  }
  std::vector<std::uint8_t> strange(seen.size());
  for (std::size_t p = 0; p < seen.size(); p++) {
    const Vec3d length = hadamard(Vec3d(seen[p].high - seen[p].low), side);
    strange[p] = std::max({length.x, length.y, length.z}) >= kLength && 2 * seen[p].beyond > parts.sizes[p];
  }
  return strange;
}

}  // namespace

DenseCells make_dense_cells(const Grid& ct) {
  DenseCells cells;
  for (int a = 0; a < 3; a++) {
    cells.cell[a] = std::max(1, int(std::lround(kCell / ct.spacing[a])));
    cells.size[a] = (ct.size[a] + cells.cell[a] - 1) / cells.cell[a];
  }
  const std::size_t count = std::size_t(cells.size.x) * std::size_t(cells.size.y) * std::size_t(cells.size.z);
  cells.any.resize(count), cells.all.resize(count);
  return cells;
}

void pool_cells(const Exec& exec, const CtPart& ct, double air_max, Layers layers, DenseCells& cells) {
  const auto bound = std::int16_t(std::clamp(std::ceil(air_max), -32768.0, 32767.0));
  parallel_for(exec, std::size_t(layers.end - layers.begin), PoolLayer{ct, cells, bound, layers.begin});
}

Surroundings find_beside_body(const Exec& exec, const CtVolume& ct, double air_max) {
  DenseCells cells = make_dense_cells(ct.grid);
  pool_cells(exec, ct, air_max, {0, cells.size.z}, cells);
  return find_beside_body(exec, ct.grid, cells);
}

Surroundings find_beside_body(const Exec& exec, const Grid& ct, const DenseCells& cells) {
  Surroundings found{.cell = cells.cell, .size = cells.size, .mask = {}, .row_mask = {}};
  const Int3 size = found.size;
  const Mask &any = cells.any, &all = cells.all;
  const std::size_t count = any.size();
  const Mask core = core_of(all, size);
  Mask near_core = core;
  dilate(exec, near_core, size, 1);
  Mask rest(count);
  for (std::size_t n = 0; n < count; n++) rest[n] = any[n] & std::uint8_t(1 - near_core[n]);
  const RowComponents parts = row_components(rest, size);
  const std::vector<std::uint8_t> strange =
      strange_parts(parts, Silhouette(core, size, long_axis(ct)), hadamard(ct.spacing, Vec3d(found.cell)));
  found.mask.assign(count, 0);
  found.row_mask.assign(std::size_t(size.y) * std::size_t(size.z), 0);
  for (const CellRun& run : parts.runs)
    if (strange[std::size_t(run.part)])
      std::fill_n(found.mask.begin() + ((std::ptrdiff_t(run.k) * size.y + run.j) * size.x + run.begin),
                  run.end - run.begin, std::uint8_t(1));
  // Where it touches the body's rim, it takes the rim's cells that are not the body's core.
  dilate(exec, found.mask, size, 1);
  for (std::size_t n = 0; n < count; n++) {
    found.mask[n] = found.mask[n] & any[n] & std::uint8_t(1 - core[n]);
    found.row_mask[n / std::size_t(size.x)] |= found.mask[n];
  }
  return found;
}

}  // namespace turgor::lattice
