#include "turgor/models/lattice/resample.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/ct_sampler.hpp"
#include "turgor/models/lattice/placed_body.hpp"

namespace turgor::lattice {

namespace {

std::int16_t to_hu(float value) { return std::int16_t(std::lrintf(std::clamp(value, -32768.0f, 32767.0f))); }

/// Places in the CT, in its voxels, along a row of output voxels.
struct CtRow {
  Vec3d first, step;

  CtRow(const Grid& out, const Grid& ct, int j, int k)
      : first(index_at(ct, point_at(out, {0, double(j), double(k)}))),
        step(index_at(ct, point_at(out, {1, double(j), double(k)})) - first) {}
  Vec3 operator[](int i) const { return Vec3(first + step * double(i)); }
};

struct CtWriter {
  const CtVolume& ct;
  Sampler sample;
  CtVolume& out;
  ResampleOptions options;
  bool same_grid;
  std::int64_t mass = 0;  // Σ HU + 1000 over the voxels of the body

  void tissue(std::size_t voxel, Int3, Vec3 at, float ratio) {
    float value = sample(at);
    if (options.conserve_mass) value = (value - kAirHu) / ratio + kAirHu;
    out.samples[voxel] = to_hu(value);
    mass += out.samples[voxel] - kAirHu;
  }
  template <class Left>
  void rest_of_row(std::size_t row, int j, int k, const std::uint8_t* covered, const Left& left) {
    const CtRow places(out.grid, ct.grid, j, k);
    for (int i = 0; i < out.grid.size.x; i++) {
      if (covered[i]) continue;
      const std::size_t voxel = row + std::size_t(i);
      if (!options.keep_surroundings || left(i))
        out.samples[voxel] = kAirHu;
      else
        out.samples[voxel] = same_grid ? ct.samples[voxel] : to_hu(sample(places[i]));
    }
  }
};

struct DisplacementWriter {
  const Grid& nodes;
  VectorVolume& out;

  void tissue(std::size_t voxel, Int3 p, Vec3 at, float) {
    out.samples[voxel] = Vec3(point_at(nodes, Vec3d(at)) - point_at(out.grid, Vec3d(p)));
  }
  template <class Left>
  void rest_of_row(std::size_t, int, int, const std::uint8_t*, const Left&) {}
};

struct JacobianWriter {
  ScalarVolume& out;

  void tissue(std::size_t voxel, Int3, Vec3, float ratio) { out.samples[voxel] = ratio; }
  template <class Left>
  void rest_of_row(std::size_t, int, int, const std::uint8_t*, const Left&) {}
};

/// Which voxels of a row held tissue in the CT, by the tetrahedron they lay in.
class TissueAtRest {
 public:
  TissueAtRest(const PlacedBody& body, int j, int k) : body_(body) {
    const Mat3d back = inverse(body.to_out);
    const Vec3d spacing = body.model.grid.spacing;
    const auto to_node = [&](Vec3d lattice) {
      return Vec3d{lattice.x / spacing.x, lattice.y / spacing.y, lattice.z / spacing.z} * double(1 << kBits);
    };
    first_ = to_node(back * (Vec3d{0, double(j), double(k)} - body.out_origin));
    step_ = to_node(back * Vec3d{1, 0, 0});
  }

  bool operator()(int i) const {
    // Snapped, so that rounding does not decide ties.
    const Vec3d at = first_ + step_ * double(i);
    const Int3 snapped{int(std::lrint(at.x)), int(std::lrint(at.y)), int(std::lrint(at.z))};
    const Int3 cell{snapped.x >> kBits, snapped.y >> kBits, snapped.z >> kBits};
    const Lattice& l = body_.model.lattice;
    if (!contains(l, cell) || body_.cells[std::size_t(node_slot(l, cell))] == Cell::kEmpty) return false;
    const int tet = kuhn_tet_at(snapped - Int3{cell.x << kBits, cell.y << kBits, cell.z << kBits});
    const auto is_tissue = [&](Int3 node) {
      return is_body(body_.model.tissue[std::size_t(node_slot(l, node))]);
    };
    const auto corners = kuhn_corners(cell, tet);
    return std::any_of(corners.begin(), corners.end(), is_tissue);
  }

 private:
  static constexpr int kBits = 16;
  const PlacedBody& body_;
  Vec3d first_, step_;
};

struct Counts {
  long folds = 0, overlaps = 0;
};

/// One slab of output layers; `writer` is the slab's own.
template <class Writer>
Counts resample_slab(const PlacedBody& body, int slab, const RestFrame& rest, Writer& writer) {
  const Int3 size = body.out.size;
  const int low = slab * kSlabLayers, layers = std::min(kSlabLayers, size.z - low);
  const std::size_t begin = sample_index(body.out, 0, 0, low);
  std::vector<std::uint8_t> covered(std::size_t(size.x) * std::size_t(size.y) * std::size_t(layers));
  Counts counts;
  counts.folds = walk_slab(body, slab, rest, [&](Int3 p, Vec3 at, float ratio) {
    const std::size_t voxel = sample_index(body.out, p.x, p.y, p.z);
    std::uint8_t& taken = covered[voxel - begin];
    counts.overlaps += taken;
    if (taken) return;
    taken = 1;
    writer.tissue(voxel, p, at, ratio);
  });
  for (int k = low; k < low + layers; k++)
    for (int j = 0; j < size.y; j++) {
      const std::size_t row = sample_index(body.out, 0, j, k);
      writer.rest_of_row(row, j, k, &covered[row - begin], TissueAtRest(body, j, k));
    }
  return counts;
}

/// All slabs, each with its own copy of `writer`; returns the copies.
template <class Writer>
std::vector<Writer> resample_with(const Exec& exec, const PlacedBody& body, const RestFrame& rest,
                                  const Writer& writer, Counts& total) {
  const auto slabs = std::size_t(slab_count(body));
  std::vector<Writer> writers(slabs, writer);
  std::vector<Counts> counts(slabs);
  parallel_for(exec, slabs,
               [&](std::size_t s) { counts[s] = resample_slab(body, int(s), rest, writers[s]); });
  for (const Counts& c : counts) total.folds += c.folds, total.overlaps += c.overlaps;
  return writers;
}

/// Σ HU + 1000 over the body in the CT: the voxels of all tetrahedra that are drawn.
struct RestMass {
  const PlacedBody& body;
  const CtVolume& ct;
  Int3 block;
  std::vector<std::int64_t>& layer_mass;

  void operator()(std::size_t layer) const {
    const Lattice& l = body.model.lattice;
    std::int64_t mass = 0;
    for (int j = 0; j + 1 < l.size.y; j++) {
      int begin = 0;  // of a run of cells that are drawn whole
      for (int i = 0; i + 1 < l.size.x; i++) {
        const Int3 cell{i, j, int(layer)};
        if (is_whole(cell)) continue;
        mass += box_mass({begin, j, cell.z}, {i, j + 1, cell.z + 1}) + part_mass(cell);
        begin = i + 1;
      }
      mass += box_mass({begin, j, int(layer)}, {l.size.x - 1, j + 1, int(layer) + 1});
    }
    layer_mass[layer] = mass;
  }

  /// All six tetrahedra have the cell's first and last corner.
  bool is_whole(Int3 cell) const {
    const auto slot = std::size_t(node_slot(body.model.lattice, cell));
    return body.cells[slot] == Cell::kPlain &&
           (body.solid[slot] || body.solid[std::size_t(node_slot(body.model.lattice, cell + Int3{1, 1, 1}))]);
  }

  std::int64_t box_mass(Int3 low, Int3 high) const {
    const Int3 from = hadamard(low, block), to = min(hadamard(high, block), ct.grid.size);
    std::int64_t mass = 0;
    for (int k = from.z; k < to.z; k++)
      for (int j = from.y; j < to.y; j++) {
        const std::int16_t* row = &ct.samples[sample_index(ct.grid, 0, j, k)];
        std::int64_t sum = 0;
        for (int i = from.x; i < to.x; i++) sum += row[i] - kAirHu;
        mass += sum;
      }
    return mass;
  }

  std::int64_t part_mass(Int3 cell) const {
    if (body.cells[std::size_t(node_slot(body.model.lattice, cell))] == Cell::kEmpty) return 0;
    const Int3 from = hadamard(cell, block), to = min(from + block, ct.grid.size);
    std::array<std::array<bool, 4>, 6> solid, removed;
    for (int t = 0; t < 6; t++)
      for (std::size_t n = 0; n < 4; n++) {
        const auto slot = std::size_t(node_slot(body.model.lattice, kuhn_corners(cell, t)[n]));
        solid[std::size_t(t)][n] = body.solid[slot] != 0;
        removed[std::size_t(t)][n] = !body.solid[slot] && is_body(body.model.tissue[slot]);
      }
    std::int64_t mass = 0;
    for (int k = from.z; k < to.z; k++)
      for (int j = from.y; j < to.y; j++)
        for (int i = from.x; i < to.x; i++) {
          const Vec3 in_block = Vec3(Int3{i, j, k} - from) + Vec3{0.5f, 0.5f, 0.5f};
          const Vec3 in_cell{in_block.x / float(block.x), in_block.y / float(block.y),
                             in_block.z / float(block.z)};
          const int tet = kuhn_tet_at(in_cell);
          const std::array<float, 4> weight = path_weights(tet, in_cell);
          bool any = false;
          float gone = 0;
          for (std::size_t n = 0; n < 4; n++) {
            any |= solid[std::size_t(tet)][n];
            if (removed[std::size_t(tet)][n]) gone += weight[n];
          }
          if (any && !(gone > 0.5f)) mass += ct.at(i, j, k) - kAirHu;
        }
    return mass;
  }
};

double rest_mass(const Exec& exec, const PlacedBody& body, const CtVolume& ct, Int3 block) {
  std::vector<std::int64_t> layer_mass(std::size_t(body.model.lattice.size.z - 1));
  parallel_for(exec, layer_mass.size(), RestMass{body, ct, block, layer_mass});
  double mass = 0;
  for (const std::int64_t m : layer_mass) mass += double(m);
  return mass;
}

}  // namespace

Grid resized(const Grid& grid, Int3 size) {
  Grid result = grid;
  result.size = size;
  for (int axis = 0; axis < 3; axis++) result.spacing[axis] *= double(grid.size[axis]) / double(size[axis]);
  const auto first = [&](int axis) { return 0.5 * (double(grid.size[axis]) / double(size[axis]) - 1); };
  result.origin = point_at(grid, {first(0), first(1), first(2)});
  return result;
}

ResampledCt resample_ct(const Exec& exec, const Model& model, const State& state, const CtVolume& ct,
                        const Grid& out, const ResampleOptions& options) {
  const Timer timer;
  const Vec3d voxel = ct.grid.spacing, step = model.grid.spacing;
  const Vec3d cell_size{step.x / voxel.x, step.y / voxel.y, step.z / voxel.z};
  const Int3 block{int(std::lround(cell_size.x)), int(std::lround(cell_size.y)),
                   int(std::lround(cell_size.z))};
  TURGOR_ASSERT(norm(cell_size - Vec3d(block)) < 1e-3,
                "the body was built from this CT, in whole blocks of its voxels");

  ResampledCt result;
  result.ct.grid = out;
  result.ct.samples.resize(sample_count(out));
  const PlacedBody body = place_body(exec, model, state, out);
  const RestFrame rest{.first_node = index_at(ct.grid, model.grid.origin), .cell_size = cell_size};
  const CtWriter writer{.ct = ct,
                        .sample = Sampler(ct),
                        .out = result.ct,
                        .options = options,
                        .same_grid = same_grid(out, ct.grid)};
  Counts counts;
  double mass = 0;
  for (const CtWriter& slab : resample_with(exec, body, rest, writer, counts)) mass += double(slab.mass);
  mass *= sample_volume(out);
  const double before = rest_mass(exec, body, ct, block) * sample_volume(ct.grid);
  result.report = {.seconds = timer.seconds(),
                   .mass_error = before > 0 ? (mass - before) / before : 0,
                   .folds = counts.folds,
                   .overlaps = counts.overlaps};
  return result;
}

VectorVolume resample_displacement(const Exec& exec, const Model& model, const State& state,
                                   const Grid& out) {
  VectorVolume result{.grid = out, .samples = std::vector<Vec3>(sample_count(out))};
  Counts counts;
  resample_with(exec, place_body(exec, model, state, out), {.first_node = {0, 0, 0}, .cell_size = {1, 1, 1}},
                DisplacementWriter{model.grid, result}, counts);
  return result;
}

ScalarVolume resample_jacobian(const Exec& exec, const Model& model, const State& state, const Grid& out) {
  ScalarVolume result{.grid = out, .samples = std::vector<float>(sample_count(out), 1)};
  Counts counts;
  resample_with(exec, place_body(exec, model, state, out), {.first_node = {0, 0, 0}, .cell_size = {1, 1, 1}},
                JacobianWriter{result}, counts);
  return result;
}

}  // namespace turgor::lattice
