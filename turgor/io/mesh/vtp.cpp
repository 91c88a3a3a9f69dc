// VTP files: VTK's surfaces in XML.
#include <fmt/format.h>

#include "turgor/io/mesh/vtk_surface.hpp"
#include "turgor/io/mesh/vtk_xml.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

/// Number of cells of a kind in a piece; zero if the attribute is missing.
Result<std::size_t> read_cell_count(const VtkXml& file, pugi::xml_node piece, const char* attribute) {
  return piece.attribute(attribute) ? read_size(file, piece, attribute) : Result<std::size_t>(std::size_t(0));
}

Status read_cells(const VtkXml& file, pugi::xml_node piece, const char* name, VtkCells& cells) {
  const Result<std::size_t> count = read_cell_count(file, piece, fmt::format("NumberOf{}", name).c_str());
  if (!count) return count.error();
  return *count > 0 ? read_corners(file, piece.child(name), *count, cells.ends, cells.nodes) : Status(Done{});
}

Status read_piece(const VtkXml& file, pugi::xml_node piece, FoundSurface& found, VtkSurface& surface) {
  const Result<std::size_t> count = read_size(file, piece, "NumberOfPoints");
  if (!count) return count.error();
  for (VtkCells* cells : {&surface.polygons, &surface.strips}) {
    cells->first_node = std::int64_t(found.vertices.size());
    cells->node_count = std::int64_t(*count);
  }
  if (*count > 0)
    if (Status done = read_points(file, piece, *count, found.vertices); !done) return done;
  if (Status done = read_cells(file, piece, "Polys", surface.polygons); !done) return done;
  if (Status done = read_cells(file, piece, "Strips", surface.strips); !done) return done;
  for (const auto& [attribute, skipped] :
       {std::pair("NumberOfVerts", &surface.points), std::pair("NumberOfLines", &surface.lines)}) {
    const Result<std::size_t> number = read_cell_count(file, piece, attribute);
    if (!number) return number.error();
    *skipped = *number;
  }
  return Done{};
}

}  // namespace

Result<FoundSurface> parse_vtp(const fs::path& path, std::string_view bytes) {
  VtkXml file{.path = path, .bytes = bytes};
  if (Status done = parse_vtk_xml(file, "PolyData"); !done) return done.error();
  FoundSurface found{.format = vtk_xml_format(file, "VTP")};
  found.frame = vtk_xml_frame(file);
  std::size_t points = 0, lines = 0;
  for (const pugi::xml_node piece : file.xml.child("VTKFile").child("PolyData").children("Piece")) {
    VtkSurface surface;
    if (Status done = read_piece(file, piece, found, surface); !done) return done.error();
    if (Status done = add_vtk_surface(found, surface); !done)
      return error_at(file, piece, done.error().message);
    points += surface.points, lines += surface.lines;
  }
  note_left_out(found, points, lines);
  return found;
}

}  // namespace turgor::io
