// Which layers of a body's nodes each process has for its own, and which it holds copies of besides.
#pragma once

#include <string>
#include <vector>

#include "mpi/ranks.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::mpi {

using lattice::Layers;

/// Layers are numbered as in the whole body.
struct Share {
  Layers owned, held;  // held: the own ones, and others' beside them
};

struct Shares {
  int layers = 0;         // of the body
  std::vector<Share> of;  // by rank
};

/// Own layers are whole pairs of slabs, as evenly as they go. Held are one layer above and, so that layers
/// are counted alike modulo four, four below; around cuts of solid tissue the place of a copy is found from
/// nodes up to five cells away and from what is cut up to seven away: there eight on both sides. Error: fewer
/// pairs than processes.
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

/// Layers of others that are held here come from those whose own they are. `layer` is where in memory a layer
/// of the whole is, `size` of it in bytes; layers are one after the other.
template <class Value>
void fetch_layers(const Ranks& ranks, const Shares& shares, Value* first_held, std::size_t layer_size) {
  std::vector<Piece> sent, received;
  const Share& mine = shares.of[std::size_t(ranks.rank)];
  const auto piece = [&](int rank, Layers l) {
    return Piece{rank, std::as_writable_bytes(
                           std::span(first_held + std::size_t(l.begin - mine.held.begin) * layer_size,
                                     std::size_t(l.end - l.begin) * layer_size))};
  };
  const auto common = [](Layers a, Layers b) {
    return Layers{std::max(a.begin, b.begin), std::min(a.end, b.end)};
  };
  for (int r = 0; r < ranks.count; r++) {
    if (r == ranks.rank) continue;
    const Share& theirs = shares.of[std::size_t(r)];
    if (const Layers l = common(mine.owned, theirs.held); l.begin < l.end) sent.push_back(piece(r, l));
    if (const Layers l = common(theirs.owned, mine.held); l.begin < l.end) received.push_back(piece(r, l));
  }
  swap_pieces(sent, received);
}

}  // namespace turgor::mpi
