#include "turgor/models/lattice/build/body_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/build/regions.hpp"

namespace turgor::lattice {

namespace {

/// Voxels around a node, which is between two voxels. A block of odd width ends in the middle of voxels: half
/// of these belongs to the next node, so that every voxel counts once in the mass of the body.
struct Range {
  int begin, end;
  int first, last;  // without the limits of the scan
  bool has_halves;  // the voxels `first` and `last` − 1 count half

  int weight(int voxel) const { return has_halves && voxel != first && voxel != last - 1 ? 2 : 1; }
  int weight() const {
    int sum = 0;
    for (int v = begin; v < end; v++) sum += weight(v);
    return sum;
  }
};
Range block_range(int i, int block, int voxels) {
  TURGOR_CHECK(block > 0 && voxels > 0, "a block has at least one voxel");
  const int reach = (block + 1) / 2, first = i * block - reach, last = i * block + reach;
  return {std::clamp(first, 0, voxels - 1), std::clamp(last, 1, voxels), first, last, block % 2 == 1};
}

/// Adds a row of voxels times a factor to the sums; surroundings count as air.
void add_row(const CtSlab& ct, const Surroundings& surroundings, const BodyVoxels& body, int j, int k,
             int factor, std::vector<int>& sums) {
  const std::int16_t* row = ct.row(j, k);
  const std::uint8_t* kinds = surroundings.row(j, k);
  for (std::size_t i = 0; i < sums.size(); i++)
    sums[i] +=
        factor *
        (kinds[int(i) / surroundings.cell.x] == kBodyCell ? row[i] : int(std::lround(body({int(i), j, k}))));
}

/// Block means of one layer of nodes. Whole rows are summed over j and k first.
struct AverageLayer {
  const CtSlab& ct;
  const Surroundings& surroundings;
  double air_max;
  Int3 block;
  const Grid& nodes;
  int first;  // first layer
  std::int16_t* hu;

  void operator()(std::size_t layer) const {
    // rows of voxels of the layer
    const Int3 voxels = ct.whole.size;
    const int nx = voxels.x;
    std::vector<int> sums(static_cast<std::size_t>(nx));
    const BodyVoxels body(ct, surroundings, air_max);
    const Range ks = block_range(first + int(layer), block.z, voxels.z);
    for (int j = 0; j < nodes.size.y; j++) {
      const Range js = block_range(j, block.y, voxels.y);
      // sums over j and k
      std::fill(sums.begin(), sums.end(), 0);
      for (int vk = ks.begin; vk < ks.end; vk++)
        for (int vj = js.begin; vj < js.end; vj++) {
          const std::int16_t* row = ct.row(vj, vk);
          const int factor = ks.weight(vk) * js.weight(vj);
          if (surroundings.has_row(vj, vk)) {
            add_row(ct, surroundings, body, vj, vk, factor, sums);
            continue;
          }
          for (int vi = 0; vi < nx; vi++) sums[std::size_t(vi)] += factor * row[vi];
        }
      // means over i
      const int rows = ks.weight() * js.weight();
      for (int i = 0; i < nodes.size.x; i++) {
        const Range is = block_range(i, block.x, nx);
        long sum = 0;
        for (int vi = is.begin; vi < is.end; vi++) sum += long(is.weight(vi)) * sums[std::size_t(vi)];
        TURGOR_CHECK(rows > 0 && is.end > is.begin, "a mean is over at least one voxel");
        const double mean = double(sum) / (double(rows) * is.weight());
        hu[sample_index(nodes, i, j, int(layer))] = std::int16_t(std::lround(mean));
      }
    }
  }
};

/// Visits all nodes reachable over axis neighbors for which `enter(index)` is true. `stack` holds the seeds;
/// `enter` must mark accepted nodes. Returns the number of visited nodes.
template <class Enter>
std::size_t flood(const Grid& grid, std::vector<std::size_t>& stack, const Enter& enter) {
  const std::size_t strides[3] = {1, std::size_t(grid.size.x),
                                  std::size_t(grid.size.x) * std::size_t(grid.size.y)};
  std::size_t visited = 0;
  while (!stack.empty()) {
    const std::size_t n = stack.back();
    stack.pop_back();
    visited++;
    // neighbors
    const Int3 p{int(n % strides[1]), int(n / strides[1]) % grid.size.y, int(n / strides[2])};
    for (int axis = 0; axis < 3; axis++) {
      if (p[axis] > 0 && enter(n - strides[axis])) stack.push_back(n - strides[axis]);
      if (p[axis] + 1 < grid.size[axis] && enter(n + strides[axis])) stack.push_back(n + strides[axis]);
    }
  }
  return visited;
}

/// 1 = air connected to the four sides of the scan. The ends do not count, because lungs and bowel are cut
/// open there.
std::vector<std::uint8_t> outside_air(const BodyNodes& nodes, double air_max) {
  TURGOR_CHECK(nodes.hu.size() == sample_count(nodes.grid), "every node has a mean CT value");
  const Int3 size = nodes.grid.size;
  std::vector<std::uint8_t> outside(nodes.hu.size());
  // seeds at the four sides
  const auto enter = [&](std::size_t n) {
    if (outside[n] || nodes.hu[n] >= air_max) return false;
    outside[n] = 1;
    return true;
  };
  std::vector<std::size_t> stack;
  const int across = (long_axis(nodes.grid) + 1) % 3, other = (across + 1) % 3;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (is_at_end({i, j, k}, size, across) || is_at_end({i, j, k}, size, other))
          if (const std::size_t n = sample_index(nodes.grid, i, j, k); enter(n)) stack.push_back(n);
  // flood fill
  flood(nodes.grid, stack, enter);
  return outside;
}

/// Marks everything except the largest connected component as outside. Returns the size of that component.
std::size_t keep_largest(const Grid& grid, std::vector<std::uint8_t>& outside) {
  // components
  std::vector<int> component(outside.size(), 0);
  int count = 0, largest = 0;
  std::size_t largest_size = 0;
  std::vector<std::size_t> stack;
  for (std::size_t seed = 0; seed < outside.size(); seed++) {
    if (outside[seed] || component[seed]) continue;
    component[seed] = ++count;
    stack.push_back(seed);
    const std::size_t size = flood(grid, stack, [&](std::size_t n) {
      if (outside[n] || component[n]) return false;
      component[n] = count;
      return true;
    });
    if (size > largest_size) largest_size = size, largest = count;
  }
  // all others become outside
  TURGOR_CHECK(all_indices(component, std::size_t(count) + 1), "labels of components lie below their count");
  for (std::size_t n = 0; n < outside.size(); n++) outside[n] = component[n] != largest || largest == 0;
  return largest_size;
}

Tissue tissue_of(double hu, const TissueParams& params) {
  if (hu < params.air_max) return Tissue::kGas;
  if (hu < params.fat_max) return Tissue::kFat;
  return hu < params.bone_min ? Tissue::kMuscle : Tissue::kBone;
}

int label_at(const LabelVolume& labels, Vec3d point) {
  const Vec3d index = index_at(labels.grid, point);
  const Int3 p{int(std::lround(index.x)), int(std::lround(index.y)), int(std::lround(index.z))};
  return contains(labels.grid, p) ? labels.at(p.x, p.y, p.z) : 0;
}

}  // namespace

float modulus_of_node(Tissue tissue, int label, const Params& params) {
  if (tissue == Tissue::kOutside) return 0;
  const auto own = params.tissue.young_of_label.find(label);
  if (label > 0 && own != params.tissue.young_of_label.end()) return float(own->second);
  switch (tissue) {
    case Tissue::kOutside:
      return 0;
    case Tissue::kGas:
      return float(params.tissue.gas);
    case Tissue::kFat:
      return float(params.tissue.fat);
    case Tissue::kMuscle:
      return float(params.tissue.muscle);
    case Tissue::kBone:
      return float(params.fix_bone ? 2 * params.tissue.muscle : params.tissue.bone);
  }
  return 0;
}

Grid node_grid(const Grid& ct, Int3 block) {
  TURGOR_ASSERT(block.x > 0 && block.y > 0 && block.z > 0, "a block has at least one voxel");
  const auto nodes = [](int voxels, int b) { return (voxels + b - 1) / b + 1; };
  const Vec3d b(block);
  return {.size = {nodes(ct.size.x, block.x), nodes(ct.size.y, block.y), nodes(ct.size.z, block.z)},
          .spacing = hadamard(ct.spacing, b),
          .origin = point_at(ct, {-0.5, -0.5, -0.5}),
          .axes = ct.axes};
}

Layers slices_around(const Grid& ct, Int3 block, Layers layers) {
  return {block_range(layers.begin, block.z, ct.size.z).begin,
          block_range(layers.end - 1, block.z, ct.size.z).end};
}

std::vector<std::int16_t> average_blocks(const Exec& exec, const CtSlab& ct, const Surroundings& surroundings,
                                         const Params& params, const Grid& nodes, Layers layers) {
  TURGOR_CHECK(layers.begin >= 0 && layers.begin <= layers.end && layers.end <= nodes.size.z,
               "the layers belong to the body");
  const auto count = std::size_t(layers.end - layers.begin);
  std::vector<std::int16_t> hu(count * std::size_t(nodes.size.x) * std::size_t(nodes.size.y));
  parallel_for(
      exec, count,
      AverageLayer{ct, surroundings, params.tissue.air_max, params.block, nodes, layers.begin, hu.data()});
  return hu;
}

void classify_tissues(const Exec& exec, const std::vector<std::uint8_t>& outside, const Params& params,
                      int first, int count, BodyNodes& nodes) {
  TURGOR_CHECK(outside.size() == sample_count(nodes.grid) && nodes.hu.size() == outside.size(),
               "every node has a mask and a mean CT value");
  const Int3 size = nodes.grid.size, whole{size.x, size.y, count};
  const std::size_t all = sample_count(nodes.grid);
  nodes.tissue.resize(all), nodes.young.resize(all), nodes.fixed.resize(all);
  TURGOR_CHECK(first >= 0 && first + size.z <= count, "the layers belong to the body");
  const int along = long_axis(nodes.grid);
  parallel_for(exec, std::size_t(size.z), [&](std::size_t k) {
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, int(k));
        const Tissue tissue = outside[n] ? Tissue::kOutside : tissue_of(nodes.hu[n], params.tissue);
        nodes.tissue[n] = tissue;
        nodes.young[n] = modulus_of_node(tissue, 0, params);
        nodes.fixed[n] = (params.fix_bone && tissue == Tissue::kBone) ||
                         (params.fix_ends && is_at_end({i, j, first + int(k)}, whole, along));
      }
  });
}

Result<BodyNodes> classify(const Exec& exec, const CtVolume& ct, const LabelVolume* labels,
                           const Params& params) {
  BodyNodes nodes;
  nodes.grid = node_grid(ct.grid, params.block);
  const Int3 size = nodes.grid.size;
  const std::size_t count = sample_count(nodes.grid);
  constexpr std::size_t kMostNodes = std::size_t(1) << 29;  // slots are int
  if (count > kMostNodes)
    return Error{"a lattice of " + std::to_string(count) + " nodes is too large: expected at most " +
                 std::to_string(kMostNodes) + ", choose a larger block"};
  // Hounsfield units of the nodes
  nodes.surroundings = find_surroundings(exec, ct, params.tissue.air_max);
  const Surroundings& surroundings = nodes.surroundings;
  nodes.hu = average_blocks(exec, ct, surroundings, params, nodes.grid, {0, size.z});

  // body
  std::vector<std::uint8_t> outside = outside_air(nodes, params.tissue.air_max);
  if (keep_largest(nodes.grid, outside) == 0)
    return Error{"the CT contains only air: expected voxels above " +
                 std::to_string(int(params.tissue.air_max)) + " HU"};

  // tissues
  classify_tissues(exec, outside, params, 0, size.z, nodes);
  const auto node_of = [&](std::size_t n) {
    return Int3{int(n % std::size_t(size.x)), int(n / std::size_t(size.x)) % size.y,
                int(n / (std::size_t(size.x) * std::size_t(size.y)))};
  };
  // moduli by label
  if (labels != nullptr && !params.tissue.young_of_label.empty()) {
    nodes.label.assign(count, 0);
    for (std::size_t n = 0; n < count; n++) {
      if (outside[n]) continue;
      const Vec3d point = point_at(nodes.grid, Vec3d(node_of(n)));
      nodes.label[n] = std::uint16_t(label_at(*labels, point));
      nodes.young[n] = modulus_of_node(nodes.tissue[n], nodes.label[n], params);
    }
  }
  nodes.regions = find_regions(exec, ct, labels, params);
  // partial cells at the surface
  if (has_partial_cells(params)) {
    const CtSlab slab(ct);
    find_partial_cells(
        exec,
        [&](Int3 cell) {
          return count_voxels(slab, surroundings, params.tissue.air_max, params.block, cell);
        },
        params.block, nodes);
    const AirLevel level{slab, surroundings, params.tissue.air_max};
    if (params.skin.enabled)
      find_surfaces(
          exec, [&](Int3 node, int family) { return cross_edge(level, params.block, node, family); }, nodes);
  }
  return nodes;
}

}  // namespace turgor::lattice
