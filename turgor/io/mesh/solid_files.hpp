// Tetrahedral and hexahedral meshes: Gmsh (1.0, 2.2 and 4.1), legacy VTK and VTU, TetGen, Medit. Formats are
// recognized by content. Invalid elements are repaired or refused on reading, with the file's own element
// numbers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

struct ReadSolid {
  SolidMesh mesh;
  std::string format;              // "Gmsh 2.2 (binary)"
  std::size_t inverted = 0;        // inverted elements, which were reoriented
  std::vector<std::string> notes;  // repairs and ignored data: sentences
};

/// Reads tetrahedra, or hexahedra if the file has no tetrahedra; coordinates times `scale` (0.001 for a file
/// in mm). Nodes that no element uses are dropped, and elements with nodes on their edges keep the corners.
/// Physical groups (or cell data named region, material or label) become regions. Error: damaged, flat or
/// twisted elements.
Result<ReadSolid> read_solid(const std::filesystem::path& path, double scale = 1);

/// True if a file begins like one of these formats.
bool is_solid_file(const std::filesystem::path& path);

/// Writes Gmsh 2.2 as text, with the regions as physical groups.
Status write_msh(const std::filesystem::path& path, const SolidMesh& mesh);

}  // namespace turgor
