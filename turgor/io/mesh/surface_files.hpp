// Triangle surfaces in: OBJ, STL, PLY, VTP and legacy VTK (PolyData), recognised by content. Read by the
// engine itself: Assimp 5.2 reads past the end of damaged PLY files and aborts on damaged polygons, which a
// program that opens people's files cannot have.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct ReadSurface {
  TriMesh mesh;                    // vertices and triangles alone
  std::string format;              // "STL (binary)"
  std::vector<std::string> notes;  // what was left out: sentences
};

/// Vertices times `scale` (0.001 for a file in mm); those at exactly one place become one, polygons become
/// triangles. Whether the surface is closed is another question: check_surface. Error: damaged, or no
/// triangles.
Result<ReadSurface> read_surface(const std::filesystem::path& path, double scale = 1);

/// Whether a file is one of these formats.
bool is_surface_file(const std::filesystem::path& path);

}  // namespace turgor
