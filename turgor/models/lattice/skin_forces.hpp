// What one triangle of skin asks of one of its corners, by the law of the model.
#pragma once

#include "turgor/models/lattice/kernels.hpp"

namespace turgor::lattice {

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

  /// `shift1`, `shift2`: displacements of the triangle's second and third corner beyond that of the first
  /// [m].
  void add(NodeSystem& s, const SkinTriangle& t, int corner, Vec3 shift1, Vec3 shift2) const {
    const Vec3 x[3] = {{0, 0, 0}, t.edge1 + shift1, t.edge2 + shift2};
    if (law == SkinLaw::kFibre) return add_skin_fibre(s, x, corner, t, fibre);
    const Real rest = rest_ratio * t.area;
    add_skin_area(s, x[corner], x[(corner + 1) % 3], x[(corner + 2) % 3], rest, stiffness / rest,
                  amplification);
  }
};

}  // namespace turgor::lattice
