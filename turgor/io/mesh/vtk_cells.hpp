// Cells as both of VTK's formats list them: all corners in one row, where each cell ends in it, what it is.
// Internal to io/.
#pragma once

#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

struct VtkCells {
  std::int64_t first_node = 0, node_count = 0, first_cell = 0;  // in the whole file
  std::vector<std::int64_t> nodes, ends, types;
  std::vector<double> regions;  // empty, or one a cell
};

/// How well the name of a field of cells says that it holds regions: 0 = not at all.
int region_rank(std::string_view name);
/// Adds the cells. The error says which one is damaged; it names no file.
Status add_vtk_cells(FoundSolid& found, const VtkCells& cells);

}  // namespace turgor::io
