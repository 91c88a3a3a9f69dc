#include "mpi/exchange.hpp"

#include <algorithm>
#include <ctime>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"

namespace turgor::mpi {

namespace {

using lattice::BladePath, lattice::VirtualNodeDisplacement, lattice::CutEdge, lattice::PendingEdgeCut;

/// Virtual nodes in layers of local numbering. Virtual nodes are sorted by slot.
std::span<VirtualNodeDisplacement> virtual_nodes_of(const Subdomain& subdomain, Layers local) {
  const auto& keys = subdomain.state.cut_elements.virtual_node_keys;
  const auto first = [&](int layer) {
    return std::lower_bound(
               keys.begin(), keys.end(),
               std::pair(row_slot(subdomain.model.anatomy.lattice, -1, layer), std::uint64_t(0))) -
           keys.begin();
  };
  const auto begin = std::size_t(first(local.begin));
  return std::span(subdomain.state.motion.virtual_u).subspan(begin, std::size_t(first(local.end)) - begin);
}

/// Packs one layer as a message.
std::vector<Real> packed(const Subdomain& subdomain, int layer) {
  const auto size = std::size_t(layer_stride(subdomain.model.anatomy.lattice));
  const int first = row_slot(subdomain.model.anatomy.lattice, -1, layer);
  std::vector<Real> message;
  message.reserve(3 * size);
  for (const auto* u :
       {&subdomain.state.motion.u.x, &subdomain.state.motion.u.y, &subdomain.state.motion.u.z})
    message.insert(message.end(), u->begin() + first, u->begin() + first + std::ptrdiff_t(size));
  for (const VirtualNodeDisplacement& c : virtual_nodes_of(subdomain, {layer, layer + 1}))
    message.insert(message.end(), {c.x, c.y, c.z});
  return message;
}
void unpack(const std::vector<Real>& message, const Subdomain& subdomain, int layer) {
  const std::ptrdiff_t size = layer_stride(subdomain.model.anatomy.lattice);
  const int first = row_slot(subdomain.model.anatomy.lattice, -1, layer);
  auto from = message.begin();
  for (auto* u : {&subdomain.state.motion.u.x, &subdomain.state.motion.u.y, &subdomain.state.motion.u.z}) {
    std::copy_n(from, size, u->begin() + first);
    from += size;
  }
  for (VirtualNodeDisplacement& c : virtual_nodes_of(subdomain, {layer, layer + 1})) {
    c = {from[0], from[1], from[2]};
    from += 3;
  }
}

/// Sends one layer and receives another; ranks outside the range are skipped.
void pass_layers(Subdomain& subdomain, int to, int sent, int from, int received) {
  const Timer timer;
  const double processor_before = processor_seconds();
  const auto is_rank = [&](int rank) { return rank >= 0 && rank < subdomain.ranks.count; };
  const std::vector<Real> message = is_rank(to) ? packed(subdomain, sent) : std::vector<Real>();
  std::vector<Real> answer = is_rank(from) ? packed(subdomain, received) : std::vector<Real>();
  pass(subdomain.ranks, to, std::as_bytes(std::span(message)), from,
       std::as_writable_bytes(std::span(answer)));
  if (is_rank(from)) unpack(answer, subdomain, received);
  subdomain.traffic.bytes += std::int64_t(message.size() * sizeof(Real));
  subdomain.traffic.messages += is_rank(to);
  if (!is_rank(to) && !is_rank(from)) return;
  Traffic& traffic = subdomain.traffic;
  const double seconds = timer.seconds();
  traffic.seconds += seconds, traffic.processor_seconds += processor_seconds() - processor_before;
  if (traffic.least_seconds == 0 || seconds < traffic.least_seconds) traffic.least_seconds = seconds;
}

void after_phase(Subdomain& subdomain, int phase) {
  const Layers owned = subdomain.model.anatomy.owned;
  const int rank = subdomain.ranks.rank;
  if (phase == 0) return pass_layers(subdomain, rank - 1, owned.begin, rank + 1, owned.end);
  const int last = subdomain.model.params.solver.method == lattice::Method::kPbd ? 0 : 1;  // below the border
  pass_layers(subdomain, rank + 1, owned.end - last, rank - 1, owned.begin - last);
}

/// A virtual node in global numbering.
struct GlobalVirtualNode {
  std::int64_t slot = 0;
  std::uint64_t key = 0;
  VirtualNodeDisplacement shift;
};
/// Offsets of this process in the whole body: slots, and keys of virtual nodes (fine node numbers).
struct GlobalOffsets {
  std::int64_t slot;
  std::uint64_t key;
};
GlobalOffsets global_offsets(const Subdomain& subdomain) {
  const lattice::FineLattice fine = lattice::fine_lattice(subdomain.model);
  const int first = subdomain.model.anatomy.lattice.first;
  return {
      std::int64_t(layer_stride(subdomain.model.anatomy.lattice)) * first,
      std::uint64_t(fine.size.x) * std::uint64_t(fine.size.y) * std::uint64_t(fine.subdivisions.z * first)};
}

void refresh_virtual_nodes(Subdomain& subdomain) {
  lattice::State& state = subdomain.state;
  const GlobalOffsets first = global_offsets(subdomain);
  std::vector<GlobalVirtualNode> owned;
  for (const VirtualNodeDisplacement& shift : virtual_nodes_of(subdomain, subdomain.model.anatomy.owned)) {
    const auto& [slot, key] =
        state.cut_elements.virtual_node_keys[std::size_t(&shift - state.motion.virtual_u.data())];
    owned.push_back({slot + first.slot, key + first.key, shift});
  }
  for (const GlobalVirtualNode& global : join(subdomain.ranks, owned)) {
    const std::int64_t slot = global.slot - first.slot;
    if (slot < 0 || slot >= slot_count(subdomain.model.anatomy.lattice)) continue;
    const auto& keys = state.cut_elements.virtual_node_keys;
    const auto same =
        std::find(std::lower_bound(keys.begin(), keys.end(), std::pair(int(slot), std::uint64_t(0))),
                  keys.end(), std::pair(int(slot), global.key - first.key));
    if (same != keys.end()) state.motion.virtual_u[std::size_t(same - keys.begin())] = global.shift;
  }
}

/// Asserts that both neighbors hold the same virtual nodes of a shared layer, since sweeps send them without
/// keys.
void check_virtual_nodes(Subdomain& subdomain) {
  const Layers owned = subdomain.model.anatomy.owned;
  const auto count = [&](int layer) {
    return std::int64_t(virtual_nodes_of(subdomain, {layer, layer + 1}).size());
  };
  const auto compare = [&](int to, int sent, int from, int received) {
    const std::int64_t mine = count(sent), held = received >= 0 ? count(received) : 0;
    std::int64_t theirs = held;
    pass(subdomain.ranks, to, std::as_bytes(std::span(&mine, 1)), from,
         std::as_writable_bytes(std::span(&theirs, 1)));
    TURGOR_ASSERT(theirs == held, "neighbors hold the same virtual nodes of a layer");
  };
  const int rank = subdomain.ranks.rank;
  compare(rank - 1, owned.begin, rank + 1, rank + 1 < subdomain.ranks.count ? owned.end : -1);
  compare(rank + 1, owned.end - 1, rank - 1, owned.begin - 1);
}

void refresh(Subdomain& subdomain) {
  const std::size_t size = std::size_t(layer_stride(subdomain.model.anatomy.lattice));
  const std::size_t first = std::size_t(row_slot(subdomain.model.anatomy.lattice, -1, 0));
  for (auto* field : {&subdomain.state.motion.u, &subdomain.state.motion.v})
    for (auto* values : {&field->x, &field->y, &field->z})
      fetch_layers(subdomain.ranks, subdomain.shares, values->data() + first, size);
  refresh_virtual_nodes(subdomain);
  check_virtual_nodes(subdomain);
}

/// An edge in global numbering: its slot is relative to its layer of the whole body.
template <class Edge>
struct GlobalEdge {
  int layer = 0;
  Edge edge;
};
/// Gathers the edges of all processes. Keeps those that begin in the lowest `layers` layers held by this
/// process.
template <class Edge>
void join_edges(const Subdomain& subdomain, int layers, std::vector<Edge>& edges) {
  const lattice::Model& model = subdomain.model;
  const int stride = layer_stride(model.anatomy.lattice), border = row_slot(model.anatomy.lattice, -1, 0);
  std::vector<GlobalEdge<Edge>> owned;
  for (Edge edge : edges) {
    const int layer = (edge.slot - border) / stride;
    edge.slot -= border + layer * stride;
    owned.push_back({layer + model.anatomy.lattice.first, edge});
  }
  edges.clear();
  for (const GlobalEdge<Edge>& global : join(subdomain.ranks, owned)) {
    const int layer = global.layer - model.anatomy.lattice.first;
    if (layer < 0 || layer >= layers) continue;
    edges.push_back(global.edge);
    edges.back().slot += border + layer * stride;
  }
}

}  // namespace

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

lattice::HaloExchange halo_exchange_of(Subdomain& subdomain) {
  return {.after_phase = [&subdomain](int phase) { after_phase(subdomain, phase); },
          .refresh = [&subdomain] { refresh(subdomain); },
          .largest = [](std::uint32_t owned) { return largest(owned); },
          .join_numbers =
              [&subdomain](std::vector<double>& numbers) { numbers = join(subdomain.ranks, numbers); },
          .join_skin = [&subdomain](lattice::SkinNow& skin) { skin = join(subdomain.ranks, skin); },
          .join_edges =
              [&subdomain](BladePath& path) {
                const int layers = subdomain.model.anatomy.lattice.size.z;
                join_edges(subdomain, layers, path.edges);
                join_edges(subdomain, layers - 1, path.fine_edges);  // counted by cells
                join_edges(subdomain, layers - 1, path.lines);
              }};
}

std::vector<VirtualNodeDisplacement> all_virtual_nodes(const Subdomain& subdomain) {
  const std::span<VirtualNodeDisplacement> owned = virtual_nodes_of(subdomain, subdomain.model.anatomy.owned);
  return join(subdomain.ranks, std::vector<VirtualNodeDisplacement>(owned.begin(), owned.end()));
}

std::uint64_t state_hash(const Subdomain& subdomain) {
  const std::uint64_t hash = chain(subdomain.ranks, kHashSeed, [&](std::uint64_t below) {
    return lattice::hash_of_layers(subdomain.model, subdomain.state, below);
  });
  const std::vector<VirtualNodeDisplacement> virtual_nodes = all_virtual_nodes(subdomain);
  return virtual_nodes.empty() ? hash
                               : hash_values(std::span<const VirtualNodeDisplacement>(virtual_nodes), hash);
}

}  // namespace turgor::mpi
