// Where the skin is between the nodes of the lattice: the level of the CT at the nodes of the fine lattice.
#pragma once

#include <optional>

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/resample/ct_sampler.hpp"

namespace turgor::lattice {

/// Levels at the places of a cell: tissue where they are positive, linear through the skin [HU].
struct CellLevels {
  std::array<Real, kMostPlaces> at;
};

class CtLevelSet {
 public:
  /// `ct` may be null: then levels are the nodes' own.
  CtLevelSet(const Model& model, const State& state, const FineLattice& fine, const CtVolume* ct);
  /// Nodes of the body are tissue and nodes of air are air, as they were told apart by the means of their
  /// blocks; around both the level is the CT's. Where it says otherwise than a node, what the node is beyond
  /// it fades out towards the next ones, so that nothing jumps and a table beside the body is air. Beside gas
  /// in the body and what was removed, nodes decide.
  CellLevels operator()(int slot) const;

 private:
  Real sample(Vec3d place) const;

  const Model& model_;
  const State& state_;
  const FineLattice& fine_;
  std::optional<Sampler> sampler_;
  Vec3d first_, cell_size_;  // of the nodes among the voxels
};

}  // namespace turgor::lattice
