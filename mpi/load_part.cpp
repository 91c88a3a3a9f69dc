#include "mpi/load_part.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "mpi/outside.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::mpi {

namespace {

using lattice::BodyNodes, lattice::CtPart, lattice::DenseCells;

Result<Grid> grid_of(const CtSource& source) {
  return source.phantom ? Result<Grid>(phantom_grid(*source.phantom)) : read_ct_grid(source.file);
}
Result<std::vector<std::int16_t>> slices_of(const Exec& exec, const CtSource& source, Layers slices) {
  if (!source.phantom) return read_ct_slices(exec, source.file, slices.begin, slices.end);
  return make_phantom_slices(exec, *source.phantom, slices.begin, slices.end);
}

/// Layers of cells that are pooled here: those that begin in the slices between own layers of nodes.
Layers own_cells(const Share& share, Int3 block, const Grid& ct, const DenseCells& cells, bool is_last) {
  const auto first = [&](int layer) {
    return std::min(cells.size.z, (std::min(layer * block.z, ct.size.z) + cells.cell.z - 1) / cells.cell.z);
  };
  return {first(share.owned.begin), is_last ? cells.size.z : first(share.owned.end)};
}

/// The whole picture of what is dense, of which everybody adds some layers.
void join_cells(const Ranks& ranks, Layers owned, DenseCells& cells) {
  const std::ptrdiff_t layer = std::ptrdiff_t(cells.size.x) * cells.size.y;
  for (auto* mask : {&cells.any, &cells.all})
    *mask = join(ranks, std::vector<std::uint8_t>(mask->begin() + owned.begin * layer,
                                                  mask->begin() + owned.end * layer));
}

/// The means of all layers that are held, of which own ones are known.
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

/// What own slices say of the body: means of own layers, and what is known to all.
struct Known {
  std::vector<std::int16_t> hu;
  std::int64_t voxels = 0;
};
Result<Known> read_part(const Exec& exec, const Ranks& ranks, const LatticeScene& scene, const Grid& ct,
                        const Share& share, const lattice::Params& params, const Grid& nodes) {
  DenseCells cells = lattice::make_dense_cells(ct);
  const Layers owned = own_cells(share, params.block, ct, cells, ranks.rank + 1 == ranks.count);
  Layers slices = lattice::slices_around(ct, params.block, share.owned);
  if (owned.begin < owned.end) {
    slices.begin = std::min(slices.begin, owned.begin * cells.cell.z);
    slices.end = std::max(slices.end, std::min(owned.end * cells.cell.z, ct.size.z));
  }
  const Result<std::vector<std::int16_t>> samples = slices_of(exec, scene.ct, slices);
  if (const Status read = agree(ranks, samples ? Status(Done{}) : Status(samples.error())); !read)
    return read.error();
  const CtPart part(ct, slices.begin, *samples);
  lattice::pool_cells(exec, part, params.tissue.air_max, owned, cells);
  join_cells(ranks, owned, cells);
  const lattice::Surroundings beside = lattice::find_beside_body(exec, ct, cells);
  return Known{lattice::average_blocks(exec, part, beside, params, nodes, share.owned),
               std::int64_t(samples->size())};
}

std::int64_t own_count(const Grid& nodes, Layers owned, const auto& counts_node) {
  std::int64_t count = 0;
  const std::size_t layer = std::size_t(nodes.size.x) * std::size_t(nodes.size.y);
  for (std::size_t n = std::size_t(owned.begin) * layer; n < std::size_t(owned.end) * layer; n++)
    count += counts_node(n);
  return count;
}

Status fit_together(const LatticeScene& scene, const BodyNodes& nodes, LoadedPart& part) {
  lattice::Model& model = part.body.model;
  const auto is_body = [&](std::size_t n) { return lattice::is_body(nodes.tissue[n]); };
  part.body_nodes = sum(own_count(nodes.grid, nodes.owned, is_body));
  part.free_nodes =
      sum(own_count(nodes.grid, nodes.owned, [&](std::size_t n) { return is_body(n) && !nodes.fixed[n]; }));
  if (part.body_nodes > std::numeric_limits<int>::max())
    return Error{
        fmt::format("{}: a body of {} nodes is too large: expected at most {}, choose a larger block",
                    scene.place, part.body_nodes, std::numeric_limits<int>::max())};
  model.body_nodes = int(part.body_nodes), model.free_nodes = int(part.free_nodes);
  const bool has_skin = largest(std::uint32_t(!model.skin.triangles.empty())) != 0;
  if (model.params.skin.enabled && !has_skin)
    return Error{
        fmt::format("{}: the body has no skin: expected a boundary to outside air, found none in {} "
                    "body nodes",
                    scene.place, part.body_nodes)};
  return Done{};
}

}  // namespace

Result<LoadedPart> load_part(const Exec& exec, const Ranks& ranks, const LatticeScene& scene, bool is_cut) {
  const auto at_place = [&](const std::string& message) {
    return Error{fmt::format("{}: {}", scene.place, message)};
  };
  const Result<Grid> ct = grid_of(scene.ct);
  if (const Status found = agree(ranks, ct ? Status(Done{}) : Status(ct.error())); !found)
    return at_place(found.error().message);
  lattice::Params params = scene.params;
  params.block = block_of(scene, *ct);
  LoadedPart part;
  part.nodes = lattice::node_grid(*ct, params.block);
  Result<Shares> shares = share_layers(part.nodes.size.z, ranks, is_cut);
  if (!shares) return at_place(shares.error().message);
  part.shares = std::move(*shares);
  const Share share = part.shares.of[std::size_t(ranks.rank)];
  constexpr std::int64_t kMostNodes = std::int64_t(1) << 29;  // of a process: slots are counted in int
  for (const Share& s : part.shares.of)
    if (const std::int64_t held =
            std::int64_t(part.nodes.size.x) * part.nodes.size.y * (s.held.end - s.held.begin);
        held > kMostNodes)
      return at_place(fmt::format("a process would hold {} nodes: expected at most {}, take more processes",
                                  held, kMostNodes));

  const Result<Known> known = read_part(exec, ranks, scene, *ct, share, params, part.nodes);
  if (!known) return at_place(known.error().message);
  part.voxels_read = known->voxels;
  const std::vector<std::uint8_t> outside =
      find_outside(ranks, part.nodes, share.owned, known->hu, params.tissue.air_max);
  if (outside.empty())
    return at_place(
        fmt::format("the CT holds nothing but air: expected voxels above {} HU", int(params.tissue.air_max)));

  BodyNodes nodes;
  nodes.grid = part.nodes;
  nodes.grid.size.z = share.held.end - share.held.begin;
  nodes.first = share.held.begin;
  nodes.owned = {share.owned.begin - nodes.first, share.owned.end - nodes.first};
  nodes.join_skin = [&ranks](std::vector<lattice::SkinNodes>& skin) { skin = join(ranks, skin); };
  nodes.hu = held_layers(ranks, part.shares, part.nodes, known->hu);
  lattice::name_tissues(exec, held_layers(ranks, part.shares, part.nodes, outside), params, nodes.first,
                        part.nodes.size.z, nodes);
  Result<lattice::Model> model = lattice::assemble(exec, nodes, nullptr, params);
  if (!model) return at_place(model.error().message);
  part.body.name = scene.name;
  part.body.has_gravity = scene.has_gravity;
  part.body.model = std::move(*model);
  part.body.state = lattice::make_state(part.body.model);
  if (const Status fits = fit_together(scene, nodes, part); !fits) return fits.error();
  return part;
}

}  // namespace turgor::mpi
