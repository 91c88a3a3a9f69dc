// The rows of a lattice as the sweeps see them: plain pointers, and constant offsets between the ends of
// edges.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>

#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

/// Displacements and what goes with them, one value a slot.
struct NodeArrays {
  Real *ux, *uy, *uz;
  const Real *w, *root;
  const std::uint8_t* cut;

  TURGOR_HD Vec3 u(int slot) const { return {ux[slot], uy[slot], uz[slot]}; }
};

inline NodeArrays node_arrays(const Model& model, State& state) {
  return {state.u.x.data(),
          state.u.y.data(),
          state.u.z.data(),
          model.inverse_mass.data(),
          model.root_stiffness.data(),
          state.cut.data()};
}

/// Rest vectors of the seven families [m].
inline std::array<Vec3, kFamilyCount> rest_edges(const Lattice& lattice) {
  std::array<Vec3, kFamilyCount> edges;
  for (std::size_t f = 0; f < kFamilyCount; f++) edges[f] = hadamard(lattice.step, Vec3(kFamilies[f]));
  return edges;
}

/// Calls kernel(layer) for every layer, in any order and on any thread.
template <class Kernel>
void for_layers(const Exec& exec, Layers layers, const Kernel& kernel) {
  parallel_for(exec, std::size_t(layers.end - layers.begin),
               [&](std::size_t n) { kernel(std::size_t(layers.begin) + n); });
}

/// Sweeps run over slabs of layers: first all even slabs at once, then all odd ones. Within a slab, in order.
/// Two slabs of one phase never touch the same node, whatever the number of threads. `layers` are node layers
/// or cell layers and begin with an even slab. Backward, everything is done in the opposite order. Whoever
/// has only a part of a body hears of the end of each phase.
enum class Order { kForward, kBackward };
constexpr int kSlabLayers = 2;
constexpr int slab_count(Layers layers) {
  return (layers.end - layers.begin + kSlabLayers - 1) / kSlabLayers;
}

template <class SweepLayer>
void sweep_slabs(const Exec& exec, Layers layers, const SweepLayer& sweep_layer, Order order,
                 const HaloExchange* halo) {
  const bool backward = order == Order::kBackward;
  for (int turn = 0; turn < 2; turn++) {
    const int phase = backward ? 1 - turn : turn;
    parallel_for(exec, std::size_t((slab_count(layers) + 1 - phase) / 2), [&](std::size_t n) {
      const int begin = layers.begin + (2 * int(n) + phase) * kSlabLayers,
                end = std::min(begin + kSlabLayers, layers.end);
      for (int k = 0; k < end - begin; k++) sweep_layer(backward ? end - 1 - k : begin + k);
    });
    if (halo) halo->after_phase(phase);
  }
}

}  // namespace turgor::lattice
