// What the readers of solid meshes share: the elements as a file lists them, and the parsers of the formats.
// Internal to io/.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/io/mesh/mesh_cursor.hpp"
#include "turgor/io/mesh/solid_files.hpp"

namespace turgor::io {

enum class Shape : std::uint8_t { kUnknown, kPointLineOrSurface, kTet, kHex, kVoxel, kOtherSolid };

/// Of tetrahedra and hexahedra; 0 for what is not read.
constexpr int corners_of(Shape shape) {
  return shape == Shape::kTet ? 4 : shape == Shape::kHex || shape == Shape::kVoxel ? 8 : 0;
}

/// A format's element type: its shape, and how many nodes are listed, corners first.
struct ElementType {
  Shape shape = Shape::kUnknown;
  int nodes = 0;
};

/// Elements of one shape with the file's own numbers.
struct FoundElements {
  std::vector<std::int64_t> ids, regions;
  std::vector<std::int64_t> nodes;  // corners alone, 4 or 8 an element
};

/// A mesh as its file lists it.
struct FoundSolid {
  std::string format;
  std::vector<std::int64_t> node_ids;  // empty: 0, 1, 2, …
  std::vector<Vec3d> nodes;
  FoundElements tets, hexes;
  std::size_t curved = 0;        // elements whose nodes on edges, faces and inside were left out
  std::size_t other_solids = 0;  // prisms, pyramids, polyhedra: left out
  std::vector<std::string> notes;
};

/// Adds an element with all of its nodes; points, lines and surfaces are passed over.
void add_element(FoundSolid& found, ElementType type, std::int64_t id, std::int64_t region,
                 std::span<const std::int64_t> nodes);
/// The mesh the engine computes with: nodes numbered from 0, checked, turned.
Result<ReadSolid> finish_solid(const std::filesystem::path& path, const FoundSolid& found, double scale);

enum class SolidFormat { kNone, kGmsh, kVtk, kVtu, kTetgen, kMedit };
SolidFormat solid_format(std::string_view head);

Result<FoundSolid> parse_gmsh(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSolid> parse_vtk(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSolid> parse_vtu(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSolid> parse_medit(const std::filesystem::path& path, std::string_view bytes);
/// `path` is either file of the pair .node and .ele; the other one is read from beside it.
Result<FoundSolid> parse_tetgen(const std::filesystem::path& path, std::string_view bytes);

/// A coordinate that can be computed with: a number, and not absurdly far away.
bool is_place(Vec3d x);

}  // namespace turgor::io
