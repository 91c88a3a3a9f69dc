#include "turgor/io/mesh/solid_files.hpp"

#include <iterator>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/io/files/within_memory.hpp"
#include "turgor/io/mesh/mesh_bytes.hpp"
#include "turgor/io/mesh/mesh_frame.hpp"
#include "turgor/io/mesh/solid_formats.hpp"
#include "turgor/io/mesh/surface_formats.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace io {

namespace {

/// True for the first line of a TetGen file: number of points and of dimensions (3), or number of tetrahedra
/// and of nodes per tetrahedron (4 or 10).
bool begins_as_tetgen(std::string_view head) {
  FileCursor cursor("", head);
  cursor.has_comments = true;
  std::int64_t count = 0, size = 0;
  return parse_whole(cursor.word(), count) && parse_whole(cursor.word(), size) && count >= 0 &&
         (size == 3 || size == 4 || size == 10);
}

Result<FoundSolid> parse_solid(const fs::path& path, std::string_view bytes) {
  switch (solid_format(bytes)) {
    case SolidFormat::kGmsh:
      return parse_gmsh(path, bytes);
    case SolidFormat::kVtk:
      return parse_vtk(path, bytes);
    case SolidFormat::kVtu:
      return parse_vtu(path, bytes);
    case SolidFormat::kTetgen:
      return parse_tetgen(path, bytes);
    case SolidFormat::kMedit:
      return parse_medit(path, bytes);
    case SolidFormat::kNone:
      break;
  }
  return Error{
      fmt::format("{}: expected a mesh of tetrahedra or hexahedra (Gmsh, VTK, VTU, TetGen, Medit), found {}",
                  path.string(), quoted(bytes.substr(0, bytes.find('\n'))))};
}

}  // namespace

SolidFormat solid_format(std::string_view head) {
  FileCursor cursor("", head);
  const std::string_view first = cursor.word();
  if (first.starts_with("$")) return SolidFormat::kGmsh;
  if (head.starts_with("# vtk DataFile")) return SolidFormat::kVtk;
  if (first.starts_with("<?xml") || first.starts_with("<VTKFile")) return SolidFormat::kVtu;
  cursor.seek(0);
  cursor.has_comments = true;
  if (cursor.word().starts_with("MeshVersionFormatted")) return SolidFormat::kMedit;
  return begins_as_tetgen(head) ? SolidFormat::kTetgen : SolidFormat::kNone;
}

}  // namespace io

Result<ReadSolid> read_solid(const fs::path& path, double scale) {
  TURGOR_ASSERT(scale > 0, "a scale is positive");
  return io::within_memory(path, [&]() -> Result<ReadSolid> {
    const Result<std::string> bytes = io::read_mesh_bytes(path);
    if (!bytes) return bytes.error();
    const Result<io::FoundSolid> found = io::parse_solid(path, *bytes);
    if (!found) return found.error();
    Result<ReadSolid> read = io::finish_solid(path, *found, scale);
    if (read) io::note_frame(*bytes, found->frame, read->notes);
    return read;
  });
}

bool is_solid_file(const fs::path& path) {
  const std::string head = io::first_bytes(path);
  return io::solid_format(head) != io::SolidFormat::kNone &&
         io::vtk_surface_format(head) == io::SurfaceFormat::kNone;
}

Status write_msh(const fs::path& path, const SolidMesh& mesh) {
  std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", mesh.vertices.size());
  const auto out = std::back_inserter(text);
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    const Vec3d x = mesh.vertices[v];
    fmt::format_to(out, "{} {} {} {}\n", v + 1, x.x, x.y, x.z);  // shortest text that round-trips
  }
  fmt::format_to(out, "$EndNodes\n$Elements\n{}\n", element_count(mesh));
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    fmt::format_to(out, "{} {} 2 {} {}", e + 1, mesh.corners == 4 ? 4 : 5, region(mesh, e), region(mesh, e));
    for (const int v : element(mesh, e)) fmt::format_to(out, " {}", v + 1);
    text += '\n';
  }
  return write_file(path, text + "$EndElements\n");
}

}  // namespace turgor
