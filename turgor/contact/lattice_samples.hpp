// Points of the skin and of cut walls that tools can touch on a lattice.
#pragma once

#include <vector>

#include "turgor/contact/lattice_touch.hpp"

namespace turgor::contact {

/// Samples of the skin at rest, without cuts: one for every node with skin, and one between any two
/// neighbors.
std::vector<LatticeSample> skin_samples(const lattice::Model& model, const lattice::BodySurface& surface);

}  // namespace turgor::contact
