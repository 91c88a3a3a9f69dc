#include "mpi/load_subdomain.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "mpi/outside.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/build/partial_cells.hpp"

namespace turgor::mpi {

namespace {

using lattice::BodyNodes, lattice::CtSlab, lattice::DenseCells;

Result<Grid> grid_of(const CtSource& source) {
  return source.phantom ? Result<Grid>(phantom_grid(*source.phantom)) : read_ct_grid(source.file);
}
Result<std::vector<std::int16_t>> slices_of(const Exec& exec, const CtSource& source, Layers slices) {
  if (!source.phantom) return read_ct_slices(exec, source.file, slices.begin, slices.end);
  return make_phantom_slices(exec, *source.phantom, slices.begin, slices.end);
}

/// Cell layers that this process pools: those that begin in the slices between its own node layers.
Layers own_cells(const Share& share, Int3 block, const Grid& ct, const DenseCells& cells, bool is_last) {
  const auto first = [&](int layer) {
    return std::min(cells.size.z, (std::min(layer * block.z, ct.size.z) + cells.cell.z - 1) / cells.cell.z);
  };
  return {first(share.owned.begin), is_last ? cells.size.z : first(share.owned.end)};
}

/// Gathers the masks of dense cells of the whole CT; each process contributes some layers.
void join_cells(const Ranks& ranks, Layers owned, DenseCells& cells) {
  const std::ptrdiff_t layer = std::ptrdiff_t(cells.size.x) * cells.size.y;
  for (auto* mask : {&cells.any, &cells.all, &cells.dense})
    *mask = join(ranks, std::vector<std::uint8_t>(mask->begin() + owned.begin * layer,
                                                  mask->begin() + owned.end * layer));
}

/// Values of all held layers, from owned ones and those of the neighbors.
template <class Value>
std::vector<Value> held_layers(const Ranks& ranks, const Shares& shares, const Grid& nodes,
                               const std::vector<Value>& owned) {
  const Share& share = shares.of[std::size_t(ranks.rank)];
  const std::size_t size = std::size_t(nodes.size.x) * std::size_t(nodes.size.y);
  std::vector<Value> held(size * std::size_t(share.held.end - share.held.begin));
  std::copy(owned.begin(), owned.end(),
            held.begin() + std::ptrdiff_t(size) * (share.owned.begin - share.held.begin));
  fetch_layers(ranks, shares, held.data(), size);
  return held;
}

/// Crossings of the surface with the edges from a node.
using NodeCrossings = std::array<lattice::EdgeCrossing, kFamilyCount>;

/// Result of the slices read by this process, for its own layers.
struct OwnedMeans {
  std::vector<std::int16_t> hu;
  std::vector<lattice::CellVoxels> cells;  // by lowest node; empty without partial cells
  std::vector<NodeCrossings> crossings;    // by node; empty without partial cells or skin
  std::int64_t voxels = 0;
};

/// Voxels of the cells above the owned layers of nodes.
std::vector<lattice::CellVoxels> count_owned(const Exec& exec, const CtSlab& slab,
                                             const lattice::Surroundings& surroundings,
                                             const lattice::Params& params, const Grid& nodes, Layers owned) {
  const std::size_t layer = std::size_t(nodes.size.x) * std::size_t(nodes.size.y);
  std::vector<lattice::CellVoxels> cells(layer * std::size_t(owned.end - owned.begin));
  parallel_for(exec, std::size_t(owned.end - owned.begin), [&](std::size_t k) {
    for (int j = 0; j < nodes.size.y; j++)
      for (int i = 0; i < nodes.size.x; i++)
        cells[k * layer + std::size_t(j) * std::size_t(nodes.size.x) + std::size_t(i)] =
            lattice::count_voxels(slab, surroundings, params.tissue.air_max, params.block,
                                  {i, j, owned.begin + int(k)});
  });
  return cells;
}
/// Crossings of the edges from the owned layers of nodes. Those that leave the CT are in no cell.
std::vector<NodeCrossings> cross_owned(const Exec& exec, const lattice::AirLevel& level, Int3 block,
                                       const Grid& nodes, Layers owned) {
  const std::size_t layer = std::size_t(nodes.size.x) * std::size_t(nodes.size.y);
  std::vector<NodeCrossings> crossings(layer * std::size_t(owned.end - owned.begin));
  parallel_for(exec, std::size_t(owned.end - owned.begin), [&](std::size_t k) {
    for (int j = 0; j < nodes.size.y; j++)
      for (int i = 0; i < nodes.size.x; i++)
        for (std::size_t f = 0; f < kFamilyCount; f++) {
          const Int3 node{i, j, owned.begin + int(k)};
          if (contains(nodes, node + kFamilies[f]))
            crossings[k * layer + std::size_t(j) * std::size_t(nodes.size.x) + std::size_t(i)][f] =
                lattice::cross_edge(level, block, node, int(f));
        }
  });
  return crossings;
}
Result<OwnedMeans> read_owned(const Exec& exec, const Ranks& ranks, const LatticeScene& scene, const Grid& ct,
                              const Share& share, const lattice::Params& params, const Grid& nodes) {
  DenseCells cells = lattice::make_dense_cells(ct);
  const Layers owned = own_cells(share, params.block, ct, cells, ranks.rank + 1 == ranks.count);
  Layers slices = lattice::slices_around(ct, params.block, share.owned);
  if (owned.begin < owned.end) {
    slices.begin = std::min(slices.begin, owned.begin * cells.cell.z);
    slices.end = std::max(slices.end, std::min(owned.end * cells.cell.z, ct.size.z));
  }
  if (lattice::has_partial_cells(params)) {
    slices.begin = std::min(slices.begin, std::max(share.owned.begin * params.block.z - 1, 0));
    slices.end = std::max(slices.end, std::min(share.owned.end * params.block.z + 1, ct.size.z));
  }
  const Result<std::vector<std::int16_t>> samples = slices_of(exec, scene.ct, slices);
  if (const Status read = agree(ranks, samples ? Status(Done{}) : Status(samples.error())); !read)
    return read.error();
  const CtSlab slab(ct, slices.begin, *samples);
  lattice::pool_cells(exec, slab, params.tissue.air_max, owned, cells);
  join_cells(ranks, owned, cells);
  const lattice::Surroundings surroundings = lattice::find_surroundings(exec, ct, cells);
  OwnedMeans means{.hu = lattice::average_blocks(exec, slab, surroundings, params, nodes, share.owned),
                   .cells = {},
                   .crossings = {},
                   .voxels = std::int64_t(samples->size())};
  if (lattice::has_partial_cells(params))
    means.cells = count_owned(exec, slab, surroundings, params, nodes, share.owned);
  if (lattice::has_partial_cells(params) && params.skin.enabled)
    means.crossings =
        cross_owned(exec, {slab, surroundings, params.tissue.air_max}, params.block, nodes, share.owned);
  return means;
}

/// Nodes of the held layers of this process with their tissues.
BodyNodes classify_held(const Exec& exec, const Ranks& ranks, const Shares& shares, const Grid& whole,
                        const OwnedMeans& means, const std::vector<std::uint8_t>& outside,
                        const lattice::Params& params) {
  const Share& share = shares.of[std::size_t(ranks.rank)];
  BodyNodes nodes;
  nodes.grid = whole;
  nodes.grid.size.z = share.held.end - share.held.begin;
  nodes.first = share.held.begin;
  nodes.owned = {share.owned.begin - nodes.first, share.owned.end - nodes.first};
  nodes.hu = held_layers(ranks, shares, whole, means.hu);
  lattice::classify_tissues(exec, held_layers(ranks, shares, whole, outside), params, nodes.first,
                            whole.size.z, nodes);
  return nodes;
}

/// Finds the partial cells of the owned layers, from more layers than a process holds, and fetches those of
/// the halo from their owners.
void find_held_partial_cells(const Exec& exec, const Ranks& ranks, const Shares& shares, const Grid& whole,
                             const OwnedMeans& means, const std::vector<std::uint8_t>& outside,
                             const lattice::Params& params, BodyNodes& nodes) {
  // layers that determine the partial cells of owned layers
  Shares wide = shares;
  for (Share& s : wide.of)
    s.held = {std::max(0, s.owned.begin - lattice::kLayersForPartialCells),
              std::min(shares.layers, s.owned.end + lattice::kLayersForPartialCells)};
  BodyNodes around = classify_held(exec, ranks, wide, whole, means, outside, params);
  const std::vector<lattice::CellVoxels> voxels = held_layers(ranks, wide, whole, means.cells);
  lattice::find_partial_cells(
      exec,
      [&](Int3 cell) { return voxels[sample_index(around.grid, cell.x, cell.y, cell.z - around.first)]; },
      params.block, around);
  // owned layers of every process
  const std::size_t layer = std::size_t(whole.size.x) * std::size_t(whole.size.y);
  const auto held = [&](const auto& values) {
    using Value = std::decay_t<decltype(values[0])>;
    return held_layers(ranks, shares, whole,
                       std::vector<Value>(values.begin() + std::ptrdiff_t(layer) * around.owned.begin,
                                          values.begin() + std::ptrdiff_t(layer) * around.owned.end));
  };
  nodes.fill = {held(around.fill.fraction), held(around.fill.center)};
  nodes.young = held(around.young);
  // skin
  if (!params.skin.enabled) return;
  const std::vector<NodeCrossings> crossings = held_layers(ranks, shares, whole, means.crossings);
  lattice::find_surfaces(
      exec,
      [&](Int3 node, int family) {
        return crossings[sample_index(nodes.grid, node.x, node.y, node.z - nodes.first)][std::size_t(family)];
      },
      nodes);
}

std::int64_t own_count(const Grid& nodes, Layers owned, const auto& counts_node) {
  std::int64_t count = 0;
  const std::size_t layer = std::size_t(nodes.size.x) * std::size_t(nodes.size.y);
  for (std::size_t n = std::size_t(owned.begin) * layer; n < std::size_t(owned.end) * layer; n++)
    count += counts_node(n);
  return count;
}

Status set_global_counts(const LatticeScene& scene, const BodyNodes& nodes, LoadedSubdomain& loaded) {
  lattice::Model& model = loaded.body.model;
  const auto is_body = [&](std::size_t n) { return lattice::is_body(nodes.tissue[n]); };
  loaded.body_nodes = sum(own_count(nodes.grid, nodes.owned, is_body));
  loaded.free_nodes =
      sum(own_count(nodes.grid, nodes.owned, [&](std::size_t n) { return is_body(n) && !nodes.fixed[n]; }));
  if (loaded.body_nodes > std::numeric_limits<int>::max())
    return Error{
        fmt::format("{}: a body of {} nodes is too large: expected at most {}, choose a larger block",
                    scene.source_location, loaded.body_nodes, std::numeric_limits<int>::max())};
  model.anatomy.body_nodes = int(loaded.body_nodes), model.anatomy.free_nodes = int(loaded.free_nodes);
  const bool has_skin = largest(std::uint32_t(!model.anatomy.skin.triangles.empty())) != 0;
  if (model.params.skin.enabled && !has_skin)
    return Error{
        fmt::format("{}: the body has no skin: expected a boundary to outside air, found none in {} "
                    "body nodes",
                    scene.source_location, loaded.body_nodes)};
  return Done{};
}

}  // namespace

Result<LoadedSubdomain> load_subdomain(const Exec& exec, const Ranks& ranks, const LatticeScene& scene,
                                       bool is_cut) {
  const auto located = [&](const std::string& message) {
    return Error{fmt::format("{}: {}", scene.source_location, message)};
  };
  if (lattice::has_cell_laws(scene.params.tissue))
    return located(
        "a distributed body has cells of law = \"solid\" without layers, viscosity and permanent set; set "
        "that law, or run "
        "the scene with `turgor run`");
  const Result<Grid> ct = grid_of(scene.ct);
  if (const Status found = agree(ranks, ct ? Status(Done{}) : Status(ct.error())); !found)
    return located(found.error().message);
  lattice::Params params = scene.params;
  params.block = block_of(scene, *ct);
  LoadedSubdomain loaded;
  loaded.nodes = lattice::node_grid(*ct, params.block);
  Result<Shares> shares = share_layers(loaded.nodes.size.z, ranks, is_cut);
  if (!shares) return located(shares.error().message);
  loaded.shares = std::move(*shares);
  const Share share = loaded.shares.of[std::size_t(ranks.rank)];
  constexpr std::int64_t kMostNodes = std::int64_t(1) << 29;  // per process; slots are of type int
  for (const Share& s : loaded.shares.of)
    if (const std::int64_t held =
            std::int64_t(loaded.nodes.size.x) * loaded.nodes.size.y * (s.held.end - s.held.begin);
        held > kMostNodes)
      return located(fmt::format("a process would hold {} nodes: expected at most {}, take more processes",
                                 held, kMostNodes));

  const Result<OwnedMeans> means = read_owned(exec, ranks, scene, *ct, share, params, loaded.nodes);
  if (!means) return located(means.error().message);
  loaded.voxels_read = means->voxels;
  const std::vector<std::uint8_t> outside =
      find_outside(ranks, loaded.nodes, share.owned, means->hu, params.tissue.air_max);
  if (outside.empty())
    return located(
        fmt::format("the CT contains only air: expected voxels above {} HU", int(params.tissue.air_max)));

  BodyNodes nodes = classify_held(exec, ranks, loaded.shares, loaded.nodes, *means, outside, params);
  nodes.join_skin = [&ranks](std::vector<lattice::SkinNodes>& skin) { skin = join(ranks, skin); };
  if (lattice::has_partial_cells(params))
    find_held_partial_cells(exec, ranks, loaded.shares, loaded.nodes, *means, outside, params, nodes);
  Result<lattice::Model> model = lattice::assemble(exec, nodes, nullptr, params);
  if (!model) return located(model.error().message);
  loaded.body.name = scene.name;
  loaded.body.has_gravity = scene.has_gravity;
  loaded.body.model = std::move(*model);
  loaded.body.state = lattice::make_state(loaded.body.model);
  if (const Status fits = set_global_counts(scene, nodes, loaded); !fits) return fits.error();
  return loaded;
}

}  // namespace turgor::mpi
