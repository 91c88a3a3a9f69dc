// Rows of the lattice for the sweeps: plain pointers, and constant offsets between the ends of edges.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/halo.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Displacement, inverse mass, root stiffness and cut bits by slot.
struct NodeArrays {
  Real *ux, *uy, *uz;
  const Real *w, *root;
  const std::uint8_t* cut;

  TURGOR_HD Vec3 u(int slot) const { return {ux[slot], uy[slot], uz[slot]}; }
};

inline NodeArrays node_arrays(const Model& model, State& state) {
  return {state.motion.u.x.data(),
          state.motion.u.y.data(),
          state.motion.u.z.data(),
          model.anatomy.inverse_mass.data(),
          model.springs.root_stiffness.data(),
          state.cuts.cut.data()};
}

/// 1 if the edge of a family is cut, else 0. `bits`: Cuts::cut of its lower end.
TURGOR_HD inline int is_cut(std::uint8_t bits, int family) { return bits >> family & 1; }

/// Rest vectors of the seven families [m].
inline std::array<Vec3, kFamilyCount> rest_edges(const Lattice& lattice) {
  std::array<Vec3, kFamilyCount> edges;
  for (std::size_t f = 0; f < kFamilyCount; f++) edges[f] = hadamard(lattice.spacing, Vec3(kFamilies[f]));
  return edges;
}

/// Calls kernel(layer) for every layer, in any order and on any thread.
template <class Kernel>
void for_layers(const Exec& exec, Layers layers, const Kernel& kernel) {
  parallel_for(exec, std::size_t(layers.end - layers.begin),
               [&](std::size_t n) { kernel(std::size_t(layers.begin) + n); });
}

/// Order of a sweep. A sweep processes all even slabs of layers at once, then all odd slabs; layers of a slab
/// run in order. Two slabs of one phase never share a node, so the result does not depend on the number of
/// threads. `layers` are node or cell layers and begin with an even slab. Backward reverses the whole order.
/// With a halo, boundary layers are exchanged after each phase.
enum class Order { kForward, kBackward };
constexpr int kSlabLayers = 2;
constexpr int slab_count(Layers layers) {
  return (layers.end - layers.begin + kSlabLayers - 1) / kSlabLayers;
}

template <class SweepLayer>
void sweep_slabs(const Exec& exec, Layers layers, const SweepLayer& sweep_layer, Order order,
                 const HaloExchange* halo) {
  const bool backward = order == Order::kBackward;
  for (int pass = 0; pass < 2; pass++) {
    const int phase = backward ? 1 - pass : pass;
    parallel_for(exec, std::size_t((slab_count(layers) + 1 - phase) / 2), [&](std::size_t n) {
      const int begin = layers.begin + (2 * int(n) + phase) * kSlabLayers,
                end = std::min(begin + kSlabLayers, layers.end);
      for (int k = 0; k < end - begin; k++) sweep_layer(backward ? end - 1 - k : begin + k);
    });
    if (halo) halo->after_phase(phase);
  }
}

}  // namespace turgor::lattice
