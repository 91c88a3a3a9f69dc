// Points of touch samples in the cells that carry them: whole cells, and fragments of cut cells.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/models/lattice/surface/surface_sample.hpp"

namespace turgor::contact {

/// Embeds samples in the cells of a body with partial cells. A sample near a cut belongs to the fragment of
/// the nearest vertex of `surface` on its side of the cut. It moves with its nodes if no cell or fragment
/// within half a cell bears.
std::vector<lattice::EmbeddedPoint> embed_samples(const lattice::Model& model, const lattice::Cuts& cuts,
                                                  const lattice::BodySurface& surface,
                                                  std::span<const lattice::SurfaceSample> samples);

}  // namespace turgor::contact
