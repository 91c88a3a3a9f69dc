// Surfaces of both VTK formats: PolyData in XML (.vtp) and in legacy files (.vtk). Internal to io/.
#pragma once

#include "turgor/io/mesh/surface_formats.hpp"
#include "turgor/io/mesh/vtk_cells.hpp"

namespace turgor::io {

/// One piece; points and lines are only counted.
struct VtkSurface {
  VtkCells polygons, strips;
  std::size_t points = 0, lines = 0;
};

/// Adds polygons and the triangles of strips. The error names the damaged cell but no file.
Status add_vtk_surface(FoundSurface& found, const VtkSurface& surface);
/// Adds notes about cells that are not surfaces.
void note_left_out(FoundSurface& found, std::size_t points, std::size_t lines);

}  // namespace turgor::io
