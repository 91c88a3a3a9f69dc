// Exponential law of skin in directions along and across Langer's lines: tension, tangent, and the state
// without stress that belongs to the tension in the CT. In double precision, once per body.
#pragma once

#include <optional>

#include "turgor/models/lattice/mechanics/skin_exponential.hpp"

namespace turgor::lattice {

/// Stretches from the state without stress along and across Langer's lines.
struct SkinStretch {
  double along = 1, across = 1;
};

/// Tension and tangent of the membrane at a stretch, per present width [N/m]. The tangent relates the second
/// Piola-Kirchhoff stress to Green's strain, both from the present state.
struct SkinTangent {
  double tension_along = 0, tension_across = 0;
  double along = 0, across = 0, coupling = 0, shear = 0;
};
SkinTangent skin_tangent(const SkinParams& skin, SkinStretch stretch);

/// Energy per area without stress, for the images f and g of unit vectors [N/m].
double exponential_skin_energy(const SkinParams& skin, Vec3d f, Vec3d g);

/// Stretches at which the law bears the tension of the params, by Newton's method. Nothing if it does not
/// converge, as at a tension beyond the largest exponent.
std::optional<SkinStretch> stretch_of_tension(const SkinParams& skin);

/// Constants with the stretches of the CT. The params have a solution (the scene's reader checks it); without
/// one, the CT shows the state without stress.
ExponentialSkin exponential_skin(const SkinParams& skin);

/// Stiffness of the membrane along its fibers, without the stiffening, for penalties [N/m].
double skin_stiffness(const SkinParams& skin);

}  // namespace turgor::lattice
