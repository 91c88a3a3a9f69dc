// Embedding of points of the CT into the cells of a cut body.
#pragma once

#include <optional>

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

/// Embeds a rest position, lattice frame [m]. All corners of the returned point are unknowns or fixed nodes.
/// A point near the skin or in a small fragment is extrapolated from the nearest whole cell or fragment that
/// is connected to it, at most two cells away. Empty for a point outside the tissue.
std::optional<EmbeddedPoint> embed_point(const Model& model, const Cuts& cuts, const Fragments& fragments,
                                         Vec3d position);

}  // namespace turgor::lattice
