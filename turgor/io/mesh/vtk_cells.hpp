// Cells in the layout of both VTK formats: corners of all cells, end of each cell, type of each cell.
// Internal to io/.
#pragma once

#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

struct VtkCells {
  std::int64_t first_node = 0, node_count = 0, first_cell = 0;  // in the whole file
  std::vector<std::int64_t> nodes, ends, types;
  std::vector<double> regions;  // empty, or one per cell
};

/// Likelihood that a cell field of this name holds regions: 0 = none.
int region_rank(std::string_view name);
/// Adds the cells. The error names the damaged cell but no file.
Status add_vtk_cells(FoundSolid& found, const VtkCells& cells);

}  // namespace turgor::io
