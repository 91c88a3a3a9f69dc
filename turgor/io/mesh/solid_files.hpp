// Tetrahedral and hexahedral meshes in and out: Gmsh (1.0, 2.2 and 4.1), legacy VTK and VTU, TetGen, Medit.
// Formats are recognised by content. What the engine could not compute with is repaired or refused here, with
// the file's own numbers of the elements.
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
  std::size_t inverted = 0;        // elements that were listed the wrong way round, and turned
  std::vector<std::string> notes;  // what was repaired or left out: sentences
};

/// Tetrahedra, or hexahedra when the file has no tetrahedra; coordinates times `scale` (0.001 for a file in
/// mm). Nodes that no element uses are dropped, elements with nodes on their edges keep the corners, physical
/// groups (or cell data named region, material or label) become regions. Error: damaged, flat or twisted
/// elements.
Result<ReadSolid> read_solid(const std::filesystem::path& path, double scale = 1);

/// Whether a file begins as one of these formats does.
bool is_solid_file(const std::filesystem::path& path);

/// Gmsh 2.2 as text, with the regions as physical groups.
Status write_msh(const std::filesystem::path& path, const SolidMesh& mesh);

}  // namespace turgor
