// Shared by the readers of solid meshes: elements as a file lists them, and the parsers of the formats.
// Internal to io/.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/io/files/file_cursor.hpp"
#include "turgor/io/mesh/solid_files.hpp"

namespace turgor::io {

enum class Shape : std::uint8_t { kUnknown, kPointLineOrSurface, kTet, kHex, kVoxel, kOtherSolid };

/// Corners of tetrahedra and hexahedra; 0 for other shapes.
constexpr int corners_of(Shape shape) {
  return shape == Shape::kTet ? 4 : shape == Shape::kHex || shape == Shape::kVoxel ? 8 : 0;
}

/// Element type of a format: shape and number of listed nodes, corners first.
struct ElementType {
  Shape shape = Shape::kUnknown;
  int nodes = 0;
};

/// Elements of one shape with the file's own numbers.
struct FoundElements {
  std::vector<std::int64_t> ids, regions;
  std::vector<std::int64_t> nodes;  // corners only, 4 or 8 per element
};

/// A mesh as its file lists it.
struct FoundSolid {
  std::string format;
  std::vector<std::int64_t> node_ids;  // empty: 0, 1, 2, …
  std::vector<Vec3d> nodes;
  FoundElements tets, hexes;
  std::size_t curved = 0;        // elements whose nodes on edges, faces and inside are ignored
  std::size_t other_solids = 0;  // ignored prisms, pyramids, polyhedra
  std::vector<std::string> notes;
  std::string frame;  // field kFrameField of a VTK file, such as "RAS"
};

/// Adds an element with all of its nodes; points, lines and surfaces are skipped.
void add_element(FoundSolid& found, ElementType type, std::int64_t id, std::int64_t region,
                 std::span<const std::int64_t> nodes);
/// Valid mesh with nodes numbered from 0: checked and reoriented.
Result<ReadSolid> finish_solid(const std::filesystem::path& path, const FoundSolid& found, double scale);

enum class SolidFormat { kNone, kGmsh, kVtk, kVtu, kTetgen, kMedit };
SolidFormat solid_format(std::string_view head);

Result<FoundSolid> parse_gmsh(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSolid> parse_vtk(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSolid> parse_vtu(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSolid> parse_medit(const std::filesystem::path& path, std::string_view bytes);
/// `path` is either file of the pair .node and .ele; the other file is found beside it.
Result<FoundSolid> parse_tetgen(const std::filesystem::path& path, std::string_view bytes);

}  // namespace turgor::io
