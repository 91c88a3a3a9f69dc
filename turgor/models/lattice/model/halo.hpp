// One body in several processes (docs/one-huge-body.md). Each holds a run of layers, its own (Model::own),
// and beside them copies of others' that its own ones read. Own layers begin with a multiple of four, so that
// slabs and their phases are those of the whole body. What a process must hear from the others is asked for
// here; who holds the whole body has no others.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct BladePath;
/// Triangles of skin as they lie now, along the lattice's axes [m].
using SkinNow = std::vector<std::array<Vec3d, 3>>;

/// Every process calls these in the same order.
struct HaloExchange {
  /// After phase 0 or 1 of a sweep: the layers at the ends of the own ones are told and heard.
  std::function<void(int phase)> after_phase;
  /// Before a cut and after it: everything held of other layers becomes what it is there.
  std::function<void()> refresh;
  std::function<std::uint32_t(std::uint32_t)> largest;
  /// Own ones become those of all, in the order of layers.
  std::function<void(std::vector<double>&)> join_numbers;
  std::function<void(SkinNow&)> join_skin;
  /// BladePath::edges and fine_edges, of which those stay that lie in layers that are held here.
  std::function<void(BladePath&)> join_edges;
};

/// Slabs come in pairs, an even one and an odd one; own layers are whole pairs, but for the body's last ones.
constexpr int kPairLayers = 4;

/// The layers whose nodes are predicted and get their velocity here: the own ones, and those of others that a
/// sweep of these reads or moves.
inline Layers moved_layers(const Model& model) {
  const bool reads_below = model.params.solver.method == Method::kVbd;
  return {std::max(model.owned.begin - int(reads_below), 0),
          std::min(model.owned.end + 1, model.lattice.size.z)};
}

}  // namespace turgor::lattice
