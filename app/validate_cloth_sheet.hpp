// Mesh independence of a sheet.
#pragma once

#include <vector>

#include "app/validation.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/cloth.hpp"

namespace turgor {

/// Adds figures of a strip pulled along warp and weft, and of one that hangs over an edge, for several
/// triangulations.
void add_sheet_figures(const Exec& exec, bool quick, std::vector<Figure>& figures);

/// Parameters of a sheet for the cloth figures, solved to a residual of 1 %.
inline cloth::Params sheet_params(cloth::Fabric fabric) {
  fabric.law = cloth::Law::kSheet;
  return {.fabric = fabric, .solver = {.method = cloth::Method::kTwoLevel, .sweeps = 200}};
}

}  // namespace turgor
