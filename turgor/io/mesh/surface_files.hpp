// Triangle surfaces: OBJ, STL, PLY, VTP and legacy VTK (PolyData), recognized by content. The readers are our
// own, because Assimp 5.2 reads past the end of damaged PLY files and aborts on damaged polygons.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct ReadSurface {
  TriMesh mesh;                    // vertices and triangles only
  std::string format;              // "STL (binary)"
  std::vector<std::string> notes;  // ignored data: sentences
};

/// Reads vertices times `scale` (0.001 for a file in mm). Vertices at exactly the same position are welded,
/// polygons are triangulated. check_surface checks whether the surface is closed. Error: damaged, or no
/// triangles.
Result<ReadSurface> read_surface(const std::filesystem::path& path, double scale = 1);

/// True if a file has one of these formats.
bool is_surface_file(const std::filesystem::path& path);

}  // namespace turgor
