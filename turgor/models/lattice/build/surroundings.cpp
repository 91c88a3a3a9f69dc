#include "turgor/models/lattice/build/surroundings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/dilate.hpp"
#include "turgor/geometry/row_components.hpp"

namespace turgor::lattice {

namespace {

constexpr double kCell = 3e-3;       // side of a cell, unless voxels are larger [m]
constexpr double kLength = 0.1;      // least length of foreign objects [m]
constexpr double kCutLength = 0.03;  // the same, of those that a side of the scan cuts [m]
constexpr double kPad = 200;         // the core is denser than air_max by this, and so than pads [HU]
constexpr double kCore = -200;       // every tissue of the core is denser than this, fat too [HU]
constexpr std::int16_t kDense =
    -50;                      // shells of tables are denser than this, unlike covers of mattresses [HU]
constexpr int kBeside = 3;    // reach of foreign objects in which sheets on the core belong to them [cells]
constexpr int kContact = 10;  // reach of foreign objects in which skin may touch them [cells]
constexpr double kCover = 2e-3;    // thickness of a cover on the skin [m]
constexpr double kBlend = 100;     // range above the level of fat in which values are changed [HU]
constexpr double kBelowAir = 100;  // covers are lighter than air_max by this [HU]

/// Level above which the body lies next to surroundings. [HU]
double fat_level(double air_max) { return std::max(air_max, std::min(air_max + kPad, kCore)); }

using Mask = std::vector<std::uint8_t>;

/// Pools one layer of cells: least and largest voxel, each against a bound.
struct PoolLayer {
  const CtSlab& ct;
  DenseCells& cells;
  std::int16_t bound, core_bound;
  int begin;

  void operator()(std::size_t at) const {
    TURGOR_CHECK(is_index(at + std::size_t(begin), std::size_t(cells.size.z)),
                 "the layer belongs to the cells");
    const std::size_t layer = at + std::size_t(begin);
    const Int3 n = ct.whole.size, c = cells.cell;
    std::vector<std::int16_t> extremes(2 * static_cast<std::size_t>(n.x));  // by column of this row of cells
    std::int16_t *least = extremes.data(), *most = least + n.x;
    const int k0 = int(layer) * c.z, k1 = std::min(k0 + c.z, n.z);
    for (int row = 0; row < cells.size.y; row++) {
      // extremes by column
      std::fill_n(least, n.x, std::int16_t(32767));
      std::fill_n(most, n.x, std::int16_t(-32768));
      for (int k = k0; k < k1; k++)
        for (int j = row * c.y; j < std::min((row + 1) * c.y, n.y); j++) {
          const std::int16_t* hu = ct.row(j, k);
          TURGOR_LANES
          for (int i = 0; i < n.x; i++)
            least[i] = std::min(least[i], hu[i]), most[i] = std::max(most[i], hu[i]);
        }
      // extremes by cell
      const std::size_t first =
          (layer * std::size_t(cells.size.y) + std::size_t(row)) * std::size_t(cells.size.x);
      for (int i = 0; i < cells.size.x; i++) {
        const int low = i * c.x, high = std::min(low + c.x, n.x);
        cells.all[first + std::size_t(i)] = *std::min_element(least + low, least + high) >= core_bound;
        const std::int16_t densest = *std::max_element(most + low, most + high);
        cells.any[first + std::size_t(i)] = densest >= bound;
        cells.dense[first + std::size_t(i)] = densest >= std::max(core_bound, kDense);
      }
    }
  }
};

/// Largest component of fully dense cells. A gap of one voxel separates components, and a sheet thinner than
/// a cell is not part of one.
Mask core_of(const Mask& dense, Int3 size) {
  TURGOR_CHECK(dense.size() == std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z),
               "every cell has a mark");
  const RowComponents components = row_components(dense, size);
  Mask core(dense.size());
  const int largest = components.largest();
  for (const CellRun& run : components.runs)
    if (run.component == largest)
      std::fill_n(core.begin() + ((std::ptrdiff_t(run.k) * size.y + run.j) * size.x + run.begin),
                  run.end - run.begin, std::uint8_t(1));
  return core;
}

/// Removes the cells within `reach` of an unmarked one. The ends of the scan erode nothing.
void erode(const Exec& exec, Mask& mask, Int3 size, int reach) {
  for (std::uint8_t& cell : mask) cell = 1 - cell;
  dilate(exec, mask, size, reach);
  for (std::uint8_t& cell : mask) cell = 1 - cell;
}

/// Takes sheets of one or two cells out of the core within kBeside cells of foreign objects: pads on which
/// the body lies. An opening by a box of three cells keeps all that is thicker.
Mask take_sheets(const Exec& exec, Int3 size, const Mask& foreign, Mask& core) {
  Mask beside = foreign, opened = core, sheets(core.size());
  dilate(exec, beside, size, kBeside);
  erode(exec, opened, size, 1);
  dilate(exec, opened, size, 1);
  for (std::size_t n = 0; n < core.size(); n++) {
    sheets[n] = core[n] & beside[n] & std::uint8_t(1 - opened[n]);
    core[n] &= std::uint8_t(1 - sheets[n]);
  }
  return sheets;
}

/// The core with its pits filled, by a closing: where body and table share cells, the back has no holes.
Mask without_pits(const Exec& exec, Int3 size, const Mask& core) {
  Mask closed = core;
  dilate(exec, closed, size, kBeside);
  erode(exec, closed, size, kBeside);
  return closed;
}

/// First and last core cell along the two axes across the scan. Cells beyond them are visible from a side.
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

/// Marks components that are long, or cut by a side of the scan, and mostly beyond the silhouette of the
/// body.
std::vector<std::uint8_t> foreign_components(const RowComponents& components, const Silhouette& silhouette,
                                             Vec3d side, Int3 size, int along) {
  struct Bounds {
    Int3 low{1 << 30, 1 << 30, 1 << 30}, high{};
    std::size_t beyond = 0;
  };
  TURGOR_CHECK(std::all_of(components.runs.begin(), components.runs.end(),
                           [&](const CellRun& r) { return is_index(r.component, components.sizes.size()); }),
               "labels of components lie below their count");
  // bounds and cells beyond the silhouette
  std::vector<Bounds> bounds(components.sizes.size());
  for (const CellRun& run : components.runs) {
    Bounds& s = bounds[std::size_t(run.component)];
    s.low = min(s.low, Int3{run.begin, run.j, run.k});
    s.high = max(s.high, Int3{run.end, run.j + 1, run.k + 1});
    for (int i = run.begin; i < run.end; i++) s.beyond += silhouette.is_beyond({i, run.j, run.k});
  }
  // components beyond it
  std::vector<std::uint8_t> is_foreign(bounds.size());
  for (std::size_t p = 0; p < bounds.size(); p++) {
    const Bounds& b = bounds[p];
    const Vec3d length = hadamard(Vec3d(b.high - b.low), side);
    bool is_cut = false;
    for (const int axis : {(along + 1) % 3, (along + 2) % 3})
      is_cut |= b.low[axis] == 0 || b.high[axis] == size[axis];
    is_foreign[p] = std::max({length.x, length.y, length.z}) >= (is_cut ? kCutLength : kLength) &&
                    2 * b.beyond > components.sizes[p];
  }
  return is_foreign;
}

}  // namespace

DenseCells make_dense_cells(const Grid& ct) {
  DenseCells cells;
  for (int a = 0; a < 3; a++) {
    cells.cell[a] = std::max(1, int(std::lround(kCell / ct.spacing[a])));
    cells.size[a] = (ct.size[a] + cells.cell[a] - 1) / cells.cell[a];
  }
  const std::size_t count = std::size_t(cells.size.x) * std::size_t(cells.size.y) * std::size_t(cells.size.z);
  cells.any.resize(count), cells.all.resize(count), cells.dense.resize(count);
  return cells;
}

void pool_cells(const Exec& exec, const CtSlab& ct, double air_max, Layers layers, DenseCells& cells) {
  const auto whole = [](double hu) { return std::int16_t(std::clamp(std::ceil(hu), -32768.0, 32767.0)); };
  const double core = fat_level(air_max);
  parallel_for(exec, std::size_t(layers.end - layers.begin),
               PoolLayer{ct, cells, whole(air_max), whole(core), layers.begin});
}

Surroundings find_surroundings(const Exec& exec, const CtVolume& ct, double air_max) {
  DenseCells cells = make_dense_cells(ct.grid);
  pool_cells(exec, ct, air_max, {0, cells.size.z}, cells);
  return find_surroundings(exec, ct.grid, cells);
}

Surroundings find_surroundings(const Exec& exec, const Grid& ct, const DenseCells& cells) {
  Surroundings found{.cell = cells.cell, .size = cells.size, .mask = {}, .row_mask = {}};
  const Int3 size = found.size;
  const Mask &any = cells.any, &all = cells.all;
  const std::size_t count = any.size();
  // core of the body
  TURGOR_CHECK(cells.all.size() == count, "every cell has both marks");
  Mask core = core_of(all, size);
  Mask near_core = core;
  dilate(exec, near_core, size, 1);
  // dense components outside the core
  Mask rest(count);
  for (std::size_t n = 0; n < count; n++) rest[n] = any[n] & std::uint8_t(1 - near_core[n]);
  const RowComponents components = row_components(rest, size);
  const std::vector<std::uint8_t> is_foreign =
      foreign_components(components, Silhouette(core, size, long_axis(ct)),
                         hadamard(ct.spacing, Vec3d(found.cell)), size, long_axis(ct));
  // mask of the foreign components, and of those that are dense, unlike pads
  found.mask.assign(count, 0);
  found.row_mask.assign(std::size_t(size.y) * std::size_t(size.z), 0);
  if (std::find(is_foreign.begin(), is_foreign.end(), 1) == is_foreign.end()) return found;
  std::vector<std::size_t> dense_cells(components.sizes.size());
  const auto first = [&](const CellRun& run) {
    return (std::size_t(run.k) * std::size_t(size.y) + std::size_t(run.j)) * std::size_t(size.x);
  };
  for (const CellRun& run : components.runs)
    for (int i = run.begin; i < run.end; i++)
      dense_cells[std::size_t(run.component)] += cells.dense[first(run) + std::size_t(i)];
  Mask dense(count);
  for (const CellRun& run : components.runs) {
    const auto c = std::size_t(run.component);
    if (!is_foreign[c]) continue;
    const auto begin = std::ptrdiff_t(first(run)) + run.begin;
    std::fill_n(found.mask.begin() + begin, run.end - run.begin, std::uint8_t(1));
    if (2 * dense_cells[c] > components.sizes[c])
      std::fill_n(dense.begin() + begin, run.end - run.begin, std::uint8_t(1));
  }
  // skin that may touch them
  Mask contact = found.mask;
  dilate(exec, contact, size, kContact);
  const Mask sheets = take_sheets(exec, size, found.mask, core);
  // Cells next to a foreign component are masked too. A light pad stays where it touches the core, because
  // its cells contain skin; so do pits of the core.
  dilate(exec, found.mask, size, 1);
  dilate(exec, dense, size, 1);
  core = without_pits(exec, size, core);
  near_core = core;
  dilate(exec, near_core, size, 1);
  for (std::size_t n = 0; n < count; n++) {
    const std::uint8_t is_free = std::uint8_t(1 - core[n]) & (dense[n] | std::uint8_t(1 - near_core[n]));
    found.mask[n] = any[n] & ((found.mask[n] & is_free) | sheets[n]);
    // skin beside light covers is divided by voxel
    const bool is_skin = near_core[n] && !dense[n] && contact[n];
    if (any[n] && contact[n] && (found.mask[n] == kBodyCell || is_skin)) found.mask[n] = kContactCell;
    found.row_mask[n / std::size_t(size.x)] |= found.mask[n];
  }
  return found;
}

BodyVoxels::BodyVoxels(const CtSlab& ct, const Surroundings& surroundings, double air_max)
    : ct_(ct), surroundings_(surroundings), air_max_(air_max), fat_(fat_level(air_max)), square_{1, 1, 1} {
  for (int a = 0; a < 2; a++) square_[a] = std::max(2, int(std::lround(kCover / ct.whole.spacing[a])));
}

bool BodyVoxels::is_dense(Int3 voxel) const {
  return ct_.row(voxel.y, voxel.z)[voxel.x] >= fat_ && surroundings_.kind(voxel) != kForeignCell;
}

bool BodyVoxels::is_opened(Int3 voxel) const {
  if (!is_dense(voxel)) return false;
  // no cell lies between the corners of a square, since squares are not longer than cells
  const auto is_dense_square = [&](Int3 low, Int3 high) {
    for (int j = low.y; j <= high.y; j++) {
      const std::int16_t* hu = ct_.row(j, low.z);
      for (int i = low.x; i <= high.x; i++)
        if (hu[i] < fat_) return false;
    }
    return is_dense(low) && is_dense(high) && is_dense({low.x, high.y, low.z}) &&
           is_dense({high.x, low.y, low.z});
  };
  // a square of dense voxels that contains the voxel; it ends with the scan
  const Int3 last = ct_.whole.size - Int3{1, 1, 1};
  for (int b = 0; b < square_.y; b++)
    for (int a = 0; a < square_.x; a++) {
      const Int3 low = max(voxel - Int3{a, b, 0}, Int3{0, 0, 0}),
                 high = min(voxel + square_ - Int3{a + 1, b + 1, 1}, last);
      if (is_dense_square(low, high)) return true;
    }
  return false;
}

bool BodyVoxels::is_beside_opened(Int3 voxel) const {
  const Int3 low = max(voxel - Int3{1, 1, 0}, Int3{0, 0, 0}),
             high = min(voxel + Int3{1, 1, 0}, ct_.whole.size - Int3{1, 1, 1});
  for (int j = low.y; j <= high.y; j++)
    for (int i = low.x; i <= high.x; i++)
      if (is_opened({i, j, voxel.z})) return true;
  return false;
}

double BodyVoxels::changed(double hu) const {
  if (hu >= fat_ + kBlend) return hu;
  if (hu >= fat_) return fat_ + kBlend + (hu - fat_ - kBlend) * (1 + (fat_ - air_max_) / kBlend);
  return kAirHu + (hu - kAirHu) * (air_max_ - kAirHu) / (fat_ - kAirHu);
}

double BodyVoxels::operator()(Int3 voxel) const {
  const double hu = ct_.row(voxel.y, voxel.z)[voxel.x];
  switch (surroundings_.kind(voxel)) {
    case kForeignCell:
      return hu >= air_max_ ? kAirHu : hu;
    case kContactCell:
      if (is_opened(voxel)) return changed(hu);
      // a cover away from the skin is almost air, since it would make nodes beyond the skin dense
      if (hu >= air_max_ && !is_beside_opened(voxel)) return 0.5 * (air_max_ + kAirHu);
      return std::min(changed(hu), air_max_ - kBelowAir);
    default:
      return hu;
  }
}

}  // namespace turgor::lattice
