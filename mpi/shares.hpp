// Owned and held layers of a body's nodes for each process.
#pragma once

#include <string>
#include <vector>

#include "mpi/ranks.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::mpi {

using lattice::Layers;

/// Layers of one process, numbered as in the whole body.
struct Share {
  Layers owned, held;  // held: owned layers and the halo of neighbors' layers
};

struct Shares {
  int layers = 0;         // of the body
  std::vector<Share> of;  // by rank
};

/// Owned layers are whole pairs of slabs, distributed evenly. The halo has one layer above and four below, so
/// that layers have the same index modulo four. With cuts, virtual nodes are fitted from nodes up to five
/// cells away and cuts up to seven cells away, so the halo has eight layers on both sides. Error: fewer pairs
/// than processes.
inline Result<Shares> share_layers(int layers, const Ranks& ranks, bool is_cut) {
  const int pairs = (layers + lattice::kPairLayers - 1) / lattice::kPairLayers;
  if (ranks.count > pairs)
    return Error{"a body of " + std::to_string(layers) + " layers of nodes is shared by at most " +
                 std::to_string(pairs) + " processes, " + std::to_string(lattice::kPairLayers) +
                 " layers each: found " + std::to_string(ranks.count) + " processes"};
  const int below = is_cut ? 8 : 4, above = is_cut ? 8 : 1;
  Shares shares{.layers = layers, .of = {}};
  const auto first = [&](int rank) {
    return std::min(layers, int(std::int64_t(pairs) * rank / ranks.count) * lattice::kPairLayers);
  };
  for (int r = 0; r < ranks.count; r++) {
    const Layers owned{first(r), first(r + 1)};
    shares.of.push_back({owned, {std::max(0, owned.begin - below), std::min(layers, owned.end + above)}});
  }
  return shares;
}

/// Fetches halo layers from their owners. `first_held`: first held layer in memory; `layer_size`: values per
/// layer; layers are contiguous.
template <class Value>
void fetch_layers(const Ranks& ranks, const Shares& shares, Value* first_held, std::size_t layer_size) {
  std::vector<MessageBlock> sent, received;
  const Share& mine = shares.of[std::size_t(ranks.rank)];
  const auto block = [&](int rank, Layers l) {
    return MessageBlock{rank, std::as_writable_bytes(
                                  std::span(first_held + std::size_t(l.begin - mine.held.begin) * layer_size,
                                            std::size_t(l.end - l.begin) * layer_size))};
  };
  const auto common = [](Layers a, Layers b) {
    return Layers{std::max(a.begin, b.begin), std::min(a.end, b.end)};
  };
  for (int r = 0; r < ranks.count; r++) {
    if (r == ranks.rank) continue;
    const Share& theirs = shares.of[std::size_t(r)];
    if (const Layers l = common(mine.owned, theirs.held); l.begin < l.end) sent.push_back(block(r, l));
    if (const Layers l = common(theirs.owned, mine.held); l.begin < l.end) received.push_back(block(r, l));
  }
  exchange_blocks(sent, received);
}

}  // namespace turgor::mpi
