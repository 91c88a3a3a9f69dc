// CT level set: the level of the CT at the nodes of the fine lattice. Its zero set is the skin between the
// nodes of the lattice.
#pragma once

#include <optional>

#include "turgor/geometry/ct_sampler.hpp"
#include "turgor/models/lattice/build/ct_part.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Levels at the sub-lattice nodes of a cell: positive in tissue, linear through the skin [HU].
struct CellLevels {
  std::array<Real, kMaxSubNodes> at;
};

class CtLevelSet {
 public:
  /// If `ct` is null, the levels are those of the nodes. Surroundings are air.
  CtLevelSet(const Model& model, const Cuts& cuts, const FineLattice& fine, const CtVolume* ct);
  /// Levels of a cell, by the slot of its lowest node.
  ///
  /// Nodes keep their class, body or air, which was derived from block means; around them the level is the
  /// CT's, without surroundings. If the CT contradicts a node, the difference is added and fades out towards
  /// the neighboring nodes, so the level is continuous. Next to gas in the body and removed
  /// tissue, the nodes' own levels are used.
  CellLevels operator()(int slot) const;

 private:
  Real sample(Vec3d position) const;
  bool is_near_surroundings(Vec3d voxel) const;

  const Model& model_;
  const Cuts& cuts_;
  const FineLattice& fine_;
  std::optional<CtSampler> sampler_;
  std::optional<CtSlab> slab_;  // of a CT with surroundings
  Vec3d first_, cell_size_;     // of the nodes, in voxels
};

}  // namespace turgor::lattice
