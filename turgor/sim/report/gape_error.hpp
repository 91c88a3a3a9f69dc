// Error of the gape of a wound from the spacing of partial cells.
#pragma once

#include "turgor/models/lattice/model/model.hpp"

namespace turgor {

/// Expected relative error of a gape in partial cells: 0.35 spacing / length, at least 4 %. A wound gapes
/// with its length, and each end of a cut is off by a fraction of a cell. The factor bounds the errors of
/// cuts of 24 to 36 mm in any orientation with cells of 3 to 6 mm (docs/validation-lattice.md). The depth
/// hardly matters. Negative below 6 spacings of length or 1.6 spacings of depth.
double expected_gape_error_of_partial_cells(const lattice::Anatomy& anatomy, double length, double depth);

}  // namespace turgor
