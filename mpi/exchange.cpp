#include "mpi/exchange.hpp"

#include <algorithm>
#include <ctime>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"

namespace turgor::mpi {

namespace {

using lattice::BladePath, lattice::VirtualNodeShift, lattice::CutEdge, lattice::PendingEdgeCut;

/// The copies of nodes in layers as they are numbered here: they are in the order of slots.
std::span<VirtualNodeShift> virtual_nodes_of(const PartOfBody& part, Layers local) {
  const auto& places = part.state.parts.places;
  const auto first = [&](int layer) {
    return std::lower_bound(places.begin(), places.end(),
                            std::pair(row_slot(part.model.lattice, -1, layer), std::uint64_t(0))) -
           places.begin();
  };
  const auto begin = std::size_t(first(local.begin));
  return std::span(part.state.virtual_nodes).subspan(begin, std::size_t(first(local.end)) - begin);
}

/// One layer as a message, and back.
std::vector<Real> packed(const PartOfBody& part, int layer) {
  const auto size = std::size_t(layer_stride(part.model.lattice));
  const int first = row_slot(part.model.lattice, -1, layer);
  std::vector<Real> message;
  message.reserve(3 * size);
  for (const auto* u : {&part.state.u.x, &part.state.u.y, &part.state.u.z})
    message.insert(message.end(), u->begin() + first, u->begin() + first + std::ptrdiff_t(size));
  for (const VirtualNodeShift& c : virtual_nodes_of(part, {layer, layer + 1}))
    message.insert(message.end(), {c.x, c.y, c.z});
  return message;
}
void unpack(const std::vector<Real>& message, const PartOfBody& part, int layer) {
  const std::ptrdiff_t size = layer_stride(part.model.lattice);
  const int first = row_slot(part.model.lattice, -1, layer);
  auto from = message.begin();
  for (auto* u : {&part.state.u.x, &part.state.u.y, &part.state.u.z}) {
    std::copy_n(from, size, u->begin() + first);
    from += size;
  }
  for (VirtualNodeShift& c : virtual_nodes_of(part, {layer, layer + 1})) {
    c = {from[0], from[1], from[2]};
    from += 3;
  }
}

/// Sends one layer and takes another; −1: nobody is there.
void pass_layers(PartOfBody& part, int to, int sent, int from, int received) {
  const Timer timer;
  const double processor_before = processor_seconds();
  const auto is_rank = [&](int rank) { return rank >= 0 && rank < part.ranks.count; };
  const std::vector<Real> message = is_rank(to) ? packed(part, sent) : std::vector<Real>();
  std::vector<Real> answer = is_rank(from) ? packed(part, received) : std::vector<Real>();
  pass(part.ranks, to, std::as_bytes(std::span(message)), from, std::as_writable_bytes(std::span(answer)));
  if (is_rank(from)) unpack(answer, part, received);
  part.traffic.bytes += std::int64_t(message.size() * sizeof(Real));
  part.traffic.messages += is_rank(to);
  if (!is_rank(to) && !is_rank(from)) return;
  Traffic& traffic = part.traffic;
  const double seconds = timer.seconds();
  traffic.seconds += seconds, traffic.processor_seconds += processor_seconds() - processor_before;
  if (traffic.least_seconds == 0 || seconds < traffic.least_seconds) traffic.least_seconds = seconds;
}

void after_phase(PartOfBody& part, int phase) {
  const Layers owned = part.model.owned;
  const int rank = part.ranks.rank;
  if (phase == 0) return pass_layers(part, rank - 1, owned.begin, rank + 1, owned.end);
  const int last = part.model.params.solver.method == lattice::Method::kPbd ? 0 : 1;  // below the border
  pass_layers(part, rank + 1, owned.end - last, rank - 1, owned.begin - last);
}

/// A copy as all know it.
struct KnownCopy {
  std::int64_t slot = 0;
  std::uint64_t place = 0;
  VirtualNodeShift shift;
};
/// Of the whole body: slots, and fine nodes by which copies are told apart.
struct Numbers {
  std::int64_t slot;
  std::uint64_t place;
};
Numbers first_numbers(const PartOfBody& part) {
  const lattice::FineLattice fine = lattice::fine_lattice(part.model);
  const int first = part.model.lattice.first;
  return {std::int64_t(layer_stride(part.model.lattice)) * first,
          std::uint64_t(fine.size.x) * std::uint64_t(fine.size.y) * std::uint64_t(fine.parts.z * first)};
}

void refresh_copies(PartOfBody& part) {
  lattice::State& state = part.state;
  const Numbers first = first_numbers(part);
  std::vector<KnownCopy> owned;
  for (const VirtualNodeShift& shift : virtual_nodes_of(part, part.model.owned)) {
    const auto& [slot, place] = state.parts.places[std::size_t(&shift - state.virtual_nodes.data())];
    owned.push_back({slot + first.slot, place + first.place, shift});
  }
  for (const KnownCopy& known : join(part.ranks, owned)) {
    const std::int64_t slot = known.slot - first.slot;
    if (slot < 0 || slot >= slot_count(part.model.lattice)) continue;
    const auto& places = state.parts.places;
    const auto same =
        std::find(std::lower_bound(places.begin(), places.end(), std::pair(int(slot), std::uint64_t(0))),
                  places.end(), std::pair(int(slot), known.place - first.place));
    if (same != places.end()) state.virtual_nodes[std::size_t(same - places.begin())] = known.shift;
  }
}

/// A layer's copies are the same ones here and where it is an own one: sweeps send them without their names.
void check_copies(PartOfBody& part) {
  const Layers owned = part.model.owned;
  const auto count = [&](int layer) {
    return std::int64_t(virtual_nodes_of(part, {layer, layer + 1}).size());
  };
  const auto compare = [&](int to, int sent, int from, int received) {
    const std::int64_t mine = count(sent), held = received >= 0 ? count(received) : 0;
    std::int64_t theirs = held;
    pass(part.ranks, to, std::as_bytes(std::span(&mine, 1)), from,
         std::as_writable_bytes(std::span(&theirs, 1)));
    TURGOR_ASSERT(theirs == held, "neighbours know the same copies of a layer's nodes");
  };
  const int rank = part.ranks.rank;
  compare(rank - 1, owned.begin, rank + 1, rank + 1 < part.ranks.count ? owned.end : -1);
  compare(rank + 1, owned.end - 1, rank - 1, owned.begin - 1);
}

void refresh(PartOfBody& part) {
  const std::size_t size = std::size_t(layer_stride(part.model.lattice));
  const std::size_t first = std::size_t(row_slot(part.model.lattice, -1, 0));
  for (auto* field : {&part.state.u, &part.state.v})
    for (auto* values : {&field->x, &field->y, &field->z})
      fetch_layers(part.ranks, part.shares, values->data() + first, size);
  refresh_copies(part);
  check_copies(part);
}

/// An edge as all know it: its slot is counted within a layer of the whole body.
template <class Edge>
struct KnownEdge {
  int layer = 0;
  Edge edge;
};
/// Kept are those that begin in the lowest `layers` layers that are held.
template <class Edge>
void join_edges(const PartOfBody& part, int layers, std::vector<Edge>& edges) {
  const lattice::Model& model = part.model;
  const int stride = layer_stride(model.lattice), border = row_slot(model.lattice, -1, 0);
  std::vector<KnownEdge<Edge>> owned;
  for (Edge edge : edges) {
    const int layer = (edge.slot - border) / stride;
    edge.slot -= border + layer * stride;
    owned.push_back({layer + model.lattice.first, edge});
  }
  edges.clear();
  for (const KnownEdge<Edge>& known : join(part.ranks, owned)) {
    const int layer = known.layer - model.lattice.first;
    if (layer < 0 || layer >= layers) continue;
    edges.push_back(known.edge);
    edges.back().slot += border + layer * stride;
  }
}

}  // namespace

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

lattice::HaloExchange others_of(PartOfBody& part) {
  return {.after_phase = [&part](int phase) { after_phase(part, phase); },
          .refresh = [&part] { refresh(part); },
          .largest = [](std::uint32_t owned) { return largest(owned); },
          .join_numbers = [&part](std::vector<double>& numbers) { numbers = join(part.ranks, numbers); },
          .join_skin = [&part](lattice::SkinNow& skin) { skin = join(part.ranks, skin); },
          .join_edges =
              [&part](BladePath& path) {
                const int layers = part.model.lattice.size.z;
                join_edges(part, layers, path.edges);
                join_edges(part, layers - 1, path.fine_edges);  // these are counted by cells
                join_edges(part, layers - 1, path.lines);
              }};
}

std::vector<VirtualNodeShift> all_copies(const PartOfBody& part) {
  const std::span<VirtualNodeShift> owned = virtual_nodes_of(part, part.model.owned);
  return join(part.ranks, std::vector<VirtualNodeShift>(owned.begin(), owned.end()));
}

std::uint64_t state_hash(const PartOfBody& part) {
  const std::uint64_t hash = chain(part.ranks, kHashSeed, [&](std::uint64_t below) {
    return lattice::hash_of_layers(part.model, part.state, below);
  });
  const std::vector<VirtualNodeShift> virtual_nodes = all_copies(part);
  return virtual_nodes.empty() ? hash : hash_values(std::span<const VirtualNodeShift>(virtual_nodes), hash);
}

}  // namespace turgor::mpi
