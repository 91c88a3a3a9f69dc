// Points of touch samples in the cells that carry them: whole cells, and fragments of cut cells.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/models/lattice/surface/surface_sample.hpp"

namespace turgor::contact {

/// Points of samples.
struct SamplePoints {
  std::vector<lattice::EmbeddedPoint> at;  // by sample
  std::vector<std::uint8_t> is_far;        // by sample: 1 = in a whole cell far from cuts
};

/// Embeds samples in the cells of a body with partial cells. A sample near a cut belongs to the fragment of
/// the nearest vertex of `surface` on its side of the cut. It moves with its nodes if no cell or fragment
/// within half a cell bears. `known`: by sample, its earlier point if that was far from cuts, or null; it is
/// kept if no cut has come near. Empty: no point is known.
SamplePoints embed_samples(const lattice::Model& model, const lattice::Cuts& cuts,
                           const lattice::BodySurface& surface,
                           std::span<const lattice::SurfaceSample> samples,
                           std::span<const lattice::EmbeddedPoint* const> known = {});

}  // namespace turgor::contact
