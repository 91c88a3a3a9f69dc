// Whether a sheet is the same cloth on any mesh.
#pragma once

#include <vector>

#include "app/validation.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor {

/// A strip that is pulled, along warp and weft, and one that hangs over an edge, in several kinds of
/// triangles.
void add_sheet_figures(const Exec& exec, bool quick, std::vector<Figure>& figures);

/// A sheet of this fabric, solved until a hundredth is left: what the figures of cloth are of.
inline cloth::Params sheet_params(cloth::Fabric fabric) {
  fabric.law = cloth::Law::kSheet;
  return {.fabric = fabric, .solver = {.method = cloth::Method::kBlocks, .sweeps = 200}};
}

}  // namespace turgor
