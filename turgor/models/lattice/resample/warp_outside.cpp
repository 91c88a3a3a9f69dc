#include "turgor/models/lattice/resample/warp_outside.hpp"

#include <utility>
#include <vector>

#include "turgor/geometry/dilate.hpp"
#include "turgor/models/lattice/resample/partial_volume.hpp"

namespace turgor::lattice {

namespace {

using Mask = std::vector<std::uint8_t>;

/// Grows rings of voxels from all sources into voxels where `may_grow`, each with the source of its nearest
/// neighbor. Ends when no voxel of `wanted` is without a source. Returns the source of each voxel, or -1.
template <class MayGrow>
std::vector<std::int64_t> grow_sources(const Grid& grid, const Mask& is_source, const Mask& wanted,
                                       const MayGrow& may_grow) {
  const std::array<Int3, 26> offsets = neighbors_by_distance();
  std::vector<std::int64_t> source(sample_count(grid), -1);
  std::vector<Int3> ring, next;
  std::size_t missing = 0;
  // first ring: the sources
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++) {
        const std::size_t v = sample_index(grid, i, j, k);
        missing += wanted[v] && !is_source[v];
        if (!is_source[v]) continue;
        source[v] = std::int64_t(v);
        ring.push_back({i, j, k});
      }
  // one ring after the other; nearer offsets of the whole ring come first
  for (; missing > 0 && !ring.empty(); std::swap(ring, next), next.clear())
    for (const Int3 offset : offsets)
      for (const Int3 from : ring) {
        const Int3 p = from - offset;
        if (!contains(grid, p)) continue;
        const std::size_t v = sample_index(grid, p.x, p.y, p.z);
        if (source[v] >= 0 || !may_grow(v)) continue;
        source[v] = source[sample_index(grid, from.x, from.y, from.z)];
        missing -= wanted[v];
        next.push_back(p);
      }
  return source;
}

/// The body at rest on the grid of the field, in units of nodes.
struct BodyOnGrid {
  RestBody rest;
  OutputToCt to_node;
  Grid ct;  // voxels of the CT in the frame of the lattice: their spacing only

  BodyOnGrid(const Exec& exec, const Model& model, const Grid& out)
      : rest(exec, model, {0, 0, 0}, {1, 1, 1}), to_node(out, model.anatomy.grid), ct(model.anatomy.grid) {
    for (int axis = 0; axis < 3; axis++) ct.spacing[axis] /= double(model.params.block[axis]);
  }

  /// True more than a voxel of the CT inside the body at rest. Its blur begins in the outermost voxel.
  bool is_deep(Vec3d node, Int3 block) const {
    if (!rest.holds(node)) return false;
    for (int axis = 0; axis < 3; axis++) {
      Vec3d offset;
      offset[axis] = 1 / double(block[axis]);
      if (!rest.holds(node + offset) || !rest.holds(node - offset)) return false;
    }
    return true;
  }
};

}  // namespace

void fill_warp_outside(const Exec& exec, const Model& model, std::span<const std::uint8_t> covered,
                       VectorVolume& field) {
  const Grid& grid = field.grid;
  const BodyOnGrid body(exec, model, grid);
  const int reach = blur_reach(grid, body.ct);
  const auto each_voxel = [&](const auto& visit) {
    parallel_for(exec, std::size_t(grid.size.z), [&](std::size_t k) {
      for (int j = 0; j < grid.size.y; j++)
        for (int i = 0; i < grid.size.x; i++) {
          const Int3 p{i, j, int(k)};
          visit(sample_index(grid, p.x, p.y, p.z), p);
        }
    });
  };

  // voxels near the body at rest; those without tissue take a displacement
  const Mask is_covered(covered.begin(), covered.end());
  Mask near_rest(covered.size());
  each_voxel([&](std::size_t v, Int3 p) { near_rest[v] = body.rest.holds(body.to_node(p)); });
  dilate(exec, near_rest, grid.size, reach);
  Mask wanted = is_covered;
  dilate(exec, wanted, grid.size, reach);
  Mask air(covered.size());
  each_voxel([&](std::size_t v, Int3) {
    wanted[v] = (wanted[v] || near_rest[v]) && !is_covered[v];
    air[v] = !near_rest[v];
  });

  // the nearest skin, and the nearest air at rest; only voxels without tissue are written
  const std::vector<std::int64_t> skin =
      grow_sources(grid, is_covered, wanted, [&](std::size_t v) { return !is_covered[v]; });
  const std::vector<std::int64_t> to_air = grow_sources(grid, air, wanted, [](std::size_t) { return true; });
  const Mat3d to_lattice = inverse(model.anatomy.grid.axes);
  each_voxel([&](std::size_t v, Int3 p) {
    if (!wanted[v]) return;
    const Vec3d node = body.to_node(p);
    const Vec3 moved = skin[v] < 0 ? Vec3{} : field.samples[std::size_t(skin[v])];
    const Vec3d local = to_lattice * Vec3d(moved), step = model.anatomy.grid.spacing;
    const Vec3d rest = node + Vec3d{local.x / step.x, local.y / step.y, local.z / step.z};
    // with the skin, unless tissue was there; else to air
    if (skin[v] >= 0 && !body.is_deep(rest, model.params.block)) {
      field.samples[v] = moved;
    } else if (near_rest[v] && to_air[v] >= 0) {
      const auto n = std::size_t(to_air[v]);
      const auto x = std::size_t(grid.size.x), y = std::size_t(grid.size.y);
      const Vec3d source{double(n % x), double(n / x % y), double(n / (x * y))};
      field.samples[v] = Vec3(point_at(grid, source) - point_at(grid, Vec3d(p)));
    }
  });
}

}  // namespace turgor::lattice
