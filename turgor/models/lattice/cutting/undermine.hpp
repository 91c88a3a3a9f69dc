// Undermining: a horizontal blade that frees skin and the tissue above a depth from the tissue below, on both
// sides of a cut or around the wound of an excision. Surgeons do so before they close a wound whose lips do
// not meet. The freed flaps slide without friction, and nothing keeps them from entering the tissue below.
#pragma once

#include "turgor/models/lattice/cutting/blade_sheet.hpp"

namespace turgor::lattice {

/// Adds the surface at the undermined depth below the present skin, from the path to `width` on both sides,
/// outside of the outline of an excision. It is cut together with the path. Where the blade stops above bone,
/// the surface is not deeper than it. The surface ends where the skin ends, and leaves out bone and two
/// spacings around an end of the path in skin.
void add_undermining(const Model& model, const Motion& motion, const BladePath& path,
                     const Undermining& undermine, const HaloExchange* halo, BladeSheet& sheet);

}  // namespace turgor::lattice
