// Restriction of nodal forces to the corners of the coarse space, and prolongation of corner displacements to
// nodes and virtual nodes. Nodes of a half row in one block differ only in their x weight, so they are
// processed together.
#pragma once

#include "turgor/models/lattice/coarse/coarse_correction.hpp"

namespace turgor::lattice {

/// Runs of interpolated nodes in all layers, in slot order. `interpolation`: CoarseSpace::interpolation.
std::vector<ProlongationRun> find_prolongation_runs(const Lattice& lattice,
                                                    std::span<const int> interpolation);

/// Weights of all runs, in their order.
std::vector<RunWeights> weights_of_runs(const CoarseSpace& space);

/// Restriction: adds the forces at the nodes of layer `k` to the forces at rows of CoarseSpace [N].
void restrict_layer(const CoarseSpace& space, int k, LayerForces forces, std::span<Vec3d> sums);
/// Restriction: adds the residual at virtual nodes (State::workspace) to the forces at rows of CoarseSpace
/// [N].
void restrict_virtual_nodes(const Model& model, const State& state, std::span<Vec3d> sums);
/// Prolongation: displaces nodes and virtual nodes by the displacements of the rows of CoarseSpace [m].
void prolongate(const Exec& exec, const Model& model, State& state, std::span<const Vec3> corners);

}  // namespace turgor::lattice
