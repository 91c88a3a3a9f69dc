// VTU files: VTK's unstructured grids in XML.
#include <fmt/format.h>

#include "turgor/io/mesh/vtk_cells.hpp"
#include "turgor/io/mesh/vtk_xml.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

Status read_regions(const VtkXml& file, pugi::xml_node piece, std::size_t count, VtkCells& cells) {
  pugi::xml_node best;
  int best_rank = 0;
  for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
    const int rank = region_rank(array.attribute("Name").as_string());
    if (rank <= best_rank || array.attribute("NumberOfComponents").as_int(1) != 1) continue;
    best_rank = rank;
    best = array;
  }
  if (!best) return Done{};
  return read_array(file, best, count, [&](FileCursor& cursor, NumberType type) {
    cells.regions.push_back(read_real(cursor, type));
  });
}

Status read_piece(const VtkXml& file, pugi::xml_node piece, std::int64_t first_cell, FoundSolid& found,
                  VtkCells& cells) {
  const Result<std::size_t> points = read_size(file, piece, "NumberOfPoints");
  if (!points) return points.error();
  const Result<std::size_t> count = read_size(file, piece, "NumberOfCells");
  if (!count) return count.error();
  cells.first_node = std::int64_t(found.nodes.size());
  cells.first_cell = first_cell;
  cells.node_count = std::int64_t(*points);
  const pugi::xml_node arrays = piece.child("Cells");
  if (Status done = read_points(file, piece, *points, found.nodes); !done) return done;
  if (Status done = read_wholes(file, array_named(arrays, "types"), *count, cells.types); !done) return done;
  if (Status done = read_corners(file, arrays, *count, cells.ends, cells.nodes); !done) return done;
  return read_regions(file, piece, *count, cells);
}

}  // namespace

Result<FoundSolid> parse_vtu(const fs::path& path, std::string_view bytes) {
  VtkXml file{.path = path, .bytes = bytes};
  if (Status done = parse_vtk_xml(file, "UnstructuredGrid"); !done) return done.error();
  FoundSolid found{.format = vtk_xml_format(file, "VTU")};
  found.frame = vtk_xml_frame(file);
  std::int64_t first_cell = 0;
  int pieces = 0;
  for (const pugi::xml_node piece : file.xml.child("VTKFile").child("UnstructuredGrid").children("Piece")) {
    VtkCells cells;
    if (Status done = read_piece(file, piece, first_cell, found, cells); !done) return done.error();
    if (Status done = add_vtk_cells(found, cells); !done) return error_at(file, piece, done.error().message);
    first_cell += std::int64_t(cells.ends.size());
    pieces++;
  }
  if (pieces > 1)
    found.notes.push_back(fmt::format("{} pieces: points that they share are not merged", pieces));
  return found;
}

}  // namespace turgor::io
