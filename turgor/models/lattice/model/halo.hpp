// Halo exchange of one body across several processes (docs/distributed-bodies.md). Each process owns a range
// of layers (Anatomy::owned) and stores ghost layers that its own layers read. Owned layers begin at a
// multiple of four, so that slabs and phases are those of the whole body. A process with the whole body needs
// no exchange.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

struct BladePath;
/// Deformed skin triangles, along the axes of the lattice [m].
using SkinNow = std::vector<std::array<Vec3d, 3>>;

/// Collective operations: every process calls them in the same order.
struct HaloExchange {
  /// After phase 0 or 1 of a sweep: exchanges the boundary layers of the owned range.
  std::function<void(int phase)> after_phase;
  /// Before and after a cut: updates all ghost layers from their owners.
  std::function<void()> refresh;
  /// Maximum over all processes.
  std::function<std::uint32_t(std::uint32_t)> largest;
  /// Gathers the owned values of all processes in the order of layers.
  std::function<void(std::vector<double>&)> join_numbers;
  std::function<void(SkinNow&)> join_skin;
  /// Gathers BladePath::edges and fine_edges, and keeps the edges in layers of this process.
  std::function<void(BladePath&)> join_edges;
};

/// Layers in a pair of an even and an odd slab. Owned ranges are whole pairs, except at the end of the body.
constexpr int kPairLayers = 4;

/// Layers whose nodes this process predicts and whose velocities it computes: the owned layers, and the ghost
/// layers that their sweep reads or moves.
inline Layers moved_layers(const Model& model) {
  const bool reads_below = model.params.solver.method == Method::kVbd;
  return {std::max(model.anatomy.owned.begin - int(reads_below), 0),
          std::min(model.anatomy.owned.end + 1, model.anatomy.lattice.size.z)};
}

}  // namespace turgor::lattice
