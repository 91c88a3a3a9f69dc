// What skin asks of the nodes of a row, by the law of the model: many corners of triangles at once.
#pragma once

#include "turgor/models/lattice/node_systems.hpp"
#include "turgor/models/lattice/rows.hpp"

namespace turgor::lattice {

using CornerSystems = Systems<kSkinLanes>;

struct SkinForces {
  SkinLaw law;
  FibreLaw fibre;
  Real rest_ratio, stiffness, amplification;

  explicit SkinForces(const Model& model)
      : law(model.params.skin.law),
        fibre(fibre_law(model.params.skin)),
        rest_ratio(rest_area_ratio(model.params.skin)),
        stiffness(Real(model.params.skin.stiffness)),
        amplification(Real(model.params.skin.amplification)) {}

  /// What each of these corners asks of its own node.
  void gather(const SkinCorners& corners, const NodeArrays& nodes, CornerSystems& out) const;
};

}  // namespace turgor::lattice
