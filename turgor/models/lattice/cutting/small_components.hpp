// Crumbs: where blades come near each other, fine nodes between them may hang on nothing, though the tissue
// there is the tip of something larger. A part that is nowhere thicker than a fine cell, or smaller than a
// cell, is no island: it goes with the tissue beside it.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// After make_copies: gives crumbs the corners of a larger part in their cells, if possible of one on the
/// same side of the blades, and forgets the copies that nothing has then.
void merge_small_components(const State& state, Fragments& out);

}  // namespace turgor::lattice
