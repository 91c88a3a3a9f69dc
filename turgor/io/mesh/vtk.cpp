// Legacy VTK files, text or big-endian binary: unstructured grids and surfaces (POLYDATA) of versions 1 to
// 5.1.
#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "turgor/io/mesh/mesh_frame.hpp"
#include "turgor/io/mesh/vtk_surface.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

struct VtkReader {
  FileCursor cursor;
  Encoding encoding = Encoding::kText;  // of numbers; words are always text
  std::string format;
  std::vector<Vec3d> points;
  VtkCells cells;          // of a grid
  VtkSurface surface;      // of POLYDATA
  std::size_t tuples = 0;  // of the next fields
  bool of_cells = false;   // the next fields are cell data
  int rank = 0;            // of the field that gave the regions
  std::string frame;       // the field kFrameField
};

NumberType read_number_type(FileCursor& cursor) {
  const std::string name = lower_case(cursor.word());
  const bool is_unsigned = name.starts_with("unsigned_");
  const NumberType::Kind kind = is_unsigned ? NumberType::kUnsigned : NumberType::kSigned;
  const std::string size = is_unsigned ? name.substr(9) : name;
  if (size == "double") return {NumberType::kReal, 8};
  if (size == "float") return {NumberType::kReal, 4};
  if (size == "bit") return {NumberType::kUnsigned, 0};
  if (size == "char" || size == "signed_char") return {kind, 1};
  if (size == "short") return {kind, 2};
  if (size == "int" || size == "vtkidtype") return {kind, 4};  // VTK writes its ids as int
  if (size == "long" || size == "long_long" || size == "vtktypeint64") return {kind, 8};
  if (size == "vtktypeuint64") return {NumberType::kUnsigned, 8};
  cursor.fail("a type of numbers such as float or int");
  return {};
}

/// Calls take(index) `count` times; each call reads one number. In binary files the numbers begin on the next
/// line.
void read_numbers(VtkReader& in, std::size_t count, NumberType type,
                  const std::function<void(std::size_t)>& take) {
  FileCursor& cursor = in.cursor;
  if (in.encoding != Encoding::kText) cursor.line();
  cursor.encoding = in.encoding;
  if (type.bytes == 0 && in.encoding != Encoding::kText)
    cursor.skip((count + 7) / 8);
  else if (cursor.can_hold(count, {1, std::size_t(type.bytes)}, "a count of numbers"))
    for (std::size_t i = 0; i < count && cursor.ok(); i++) take(i);
  cursor.encoding = Encoding::kText;
}

void read_wholes(VtkReader& in, std::size_t count, NumberType type, std::vector<std::int64_t>& values) {
  read_numbers(in, count, type, [&](std::size_t) { values.push_back(read_whole(in.cursor, type)); });
}

void read_points(VtkReader& in) {
  if (!in.points.empty()) in.cursor.fail("one set of points", "a second one");
  const std::size_t count = in.cursor.count(4, {1, 1}, "a number of points");
  const NumberType type = read_number_type(in.cursor);
  read_numbers(in, 3 * count, type, [&](std::size_t i) {
    if (i % 3 == 0) in.points.emplace_back();
    in.points.back()[int(i % 3)] = read_real(in.cursor, type);
  });
}

/// Cells up to version 4: number of nodes, then the nodes, for each cell.
void read_counted_cells(VtkReader& in, std::size_t count, std::size_t size, VtkCells& cells) {
  std::vector<std::int64_t> values;
  read_wholes(in, size, {NumberType::kSigned, 4}, values);
  for (std::size_t at = 0; at < values.size() && in.cursor.ok();) {
    const std::size_t rest = values.size() - at - 1;
    const std::int64_t nodes = values[at++];
    if (nodes < 0 || std::uint64_t(nodes) > rest)
      return in.cursor.fail(fmt::format("a cell of at most {} nodes", rest), fmt::format("{}", nodes));
    const auto first = values.begin() + std::ptrdiff_t(at);
    cells.nodes.insert(cells.nodes.end(), first, first + nodes);
    cells.ends.push_back(std::int64_t(cells.nodes.size()));
    at += std::size_t(nodes);
  }
  if (cells.ends.size() != count)
    in.cursor.fail(fmt::format("{} cells", count), fmt::format("{}", cells.ends.size()));
}

void read_cells(VtkReader& in, VtkCells& cells) {
  FileCursor& cursor = in.cursor;
  if (!cells.ends.empty()) cursor.fail("one set of cells", "a second one");
  const std::size_t count = cursor.count(4, {1, 1}, "a number of cells");
  const std::size_t size = cursor.count(4, {1, 1}, "a number of numbers");
  if (cursor.peek_word() != "OFFSETS") return read_counted_cells(in, count, size, cells);
  cursor.word();
  read_wholes(in, count, read_number_type(cursor), cells.ends);
  cursor.expect("CONNECTIVITY");
  read_wholes(in, size, read_number_type(cursor), cells.nodes);
  if (cells.ends.empty() || cells.ends.front() != 0)
    cursor.fail("offsets that begin with 0", "others");
  else
    cells.ends.erase(cells.ends.begin());
}

/// Counts cells that are not surfaces.
void count_cells(VtkReader& in, std::size_t& count) {
  VtkCells cells;
  read_cells(in, cells);
  count += cells.ends.size();
}

void skip_metadata(FileCursor& cursor) {
  if (cursor.peek_word() != "METADATA") return;
  cursor.word();
  cursor.line();
  while (cursor.offset() < cursor.bytes().size() && !cursor.line().empty()) {
  }
}

/// Keeps regions; skips other fields.
void read_field(VtkReader& in, std::string_view name, std::size_t tuples, std::size_t components,
                NumberType type) {
  if (tuples > 0 && components > in.cursor.bytes().size() / tuples)
    return in.cursor.fail("a field that the file can hold", fmt::format("{} x {}", tuples, components));
  const int rank = in.of_cells && components == 1 && tuples == in.tuples ? region_rank(name) : 0;
  std::vector<double> values;
  const bool is_better = rank > in.rank;
  read_numbers(in, tuples * components, type, [&](std::size_t) {
    const double value = read_real(in.cursor, type);
    if (is_better) values.push_back(value);
  });
  if (!is_better || !in.cursor.ok() || type.bytes == 0) return;
  in.rank = rank;
  in.cells.regions = std::move(values);
}

void read_scalars(VtkReader& in) {
  const std::string name(in.cursor.word());
  const NumberType type = read_number_type(in.cursor);
  std::int64_t components = 1;
  if (in.cursor.peek_word() != "LOOKUP_TABLE") components = in.cursor.whole(0, "1 to 4 components");
  if (components < 1 || components > 4) in.cursor.fail("1 to 4 components");
  in.cursor.expect("LOOKUP_TABLE");
  in.cursor.word();
  read_field(in, name, in.tuples, std::size_t(components), type);
}

/// Reads strings: one line each; in binary files after their length, whose first two bits give its size in
/// bytes. Returns the first.
std::string_view read_strings(VtkReader& in, std::size_t count) {
  FileCursor& cursor = in.cursor;
  std::string_view first;
  cursor.line();
  if (!cursor.can_hold(count, {0, 1}, "a count of texts")) return first;
  for (std::size_t s = 0; s < count && cursor.ok(); s++) {
    std::string_view text;
    if (in.encoding == Encoding::kText) {
      text = cursor.line();
    } else {
      cursor.encoding = in.encoding;
      const std::size_t start = cursor.offset();
      const int bytes = 8 >> (cursor.unsigned_whole(1, "the length of a text") >> 6);
      cursor.seek(start);
      const std::uint64_t stored = cursor.unsigned_whole(bytes, "the length of a text");
      const std::uint64_t length = stored & ((std::uint64_t(1) << (8 * bytes - 2)) - 1);
      if (cursor.can_hold(length, {0, 1}, "a text")) text = cursor.skip(std::size_t(length));
    }
    if (s == 0) first = text;
  }
  cursor.encoding = Encoding::kText;
  return first;
}

void read_fields(VtkReader& in) {
  in.cursor.word();  // name of the field block
  const std::size_t count = in.cursor.count(4, {4, 4}, "a number of fields");
  for (std::size_t f = 0; f < count && in.cursor.ok(); f++) {
    skip_metadata(in.cursor);
    const std::string name(in.cursor.word());
    const std::size_t components = in.cursor.count(4, {0, 0}, "a number of components");
    const std::size_t tuples = in.cursor.count(4, {1, 0}, "a number of tuples");
    if (in.cursor.peek_word() != "string") {
      read_field(in, name, tuples, components, read_number_type(in.cursor));
      continue;
    }
    in.cursor.word();
    if (components > 1) return in.cursor.fail("texts of one component");
    const std::string_view text = read_strings(in, tuples);
    if (name == kFrameField) in.frame = text;
  }
}

/// Reads VECTORS and similar attributes: a name, a type and the components; 0 = their number follows the
/// name.
void read_attribute(VtkReader& in, std::size_t components) {
  const std::string name(in.cursor.word());
  if (components == 0) components = in.cursor.count(4, {0, 0}, "a number of components");
  read_field(in, name, in.tuples, components, read_number_type(in.cursor));
}

void read_colors(VtkReader& in, bool is_table) {
  in.cursor.word();
  const std::size_t count = in.cursor.count(4, {1, 0}, "a number");
  const NumberType type =
      in.encoding == Encoding::kText ? NumberType{} : NumberType{NumberType::kUnsigned, 1};
  is_table ? read_field(in, "", count, 4, type) : read_field(in, "", in.tuples, count, type);
}

void read_section(VtkReader& in, std::string_view keyword) {
  if (keyword == "POINTS") return read_points(in);
  if (keyword == "CELLS") return read_cells(in, in.cells);
  if (keyword == "POLYGONS") return read_cells(in, in.surface.polygons);
  if (keyword == "TRIANGLE_STRIPS") return read_cells(in, in.surface.strips);
  if (keyword == "VERTICES") return count_cells(in, in.surface.points);
  if (keyword == "LINES") return count_cells(in, in.surface.lines);
  if (keyword == "CELL_TYPES") {
    const std::size_t count = in.cursor.count(4, {1, 1}, "a number of cells");
    return read_wholes(in, count, {NumberType::kSigned, 4}, in.cells.types);
  }
  if (keyword == "CELL_DATA" || keyword == "POINT_DATA") {
    in.of_cells = keyword == "CELL_DATA";
    const std::int64_t tuples = in.cursor.whole(0, "a number of values");
    if (tuples < 0) in.cursor.fail("a number of values");
    in.tuples = std::size_t(std::max<std::int64_t>(tuples, 0));
    return;
  }
  if (keyword == "SCALARS") return read_scalars(in);
  if (keyword == "FIELD") return read_fields(in);
  if (keyword == "VECTORS" || keyword == "NORMALS") return read_attribute(in, 3);
  if (keyword == "TENSORS") return read_attribute(in, 9);
  if (keyword == "TENSORS6") return read_attribute(in, 6);
  if (keyword == "GLOBAL_IDS" || keyword == "PEDIGREE_IDS") return read_attribute(in, 1);
  if (keyword == "TEXTURE_COORDINATES") return read_attribute(in, 0);
  if (keyword == "COLOR_SCALARS" || keyword == "LOOKUP_TABLE")
    return read_colors(in, keyword == "LOOKUP_TABLE");
  in.cursor.fail("a keyword such as POINTS, CELLS, POLYGONS or CELL_DATA");
}

/// "# vtk DataFile Version 4.2", a title, "BINARY", "DATASET UNSTRUCTURED_GRID".
void read_header(VtkReader& in, std::string_view dataset) {
  const std::string_view first = in.cursor.line();
  in.cursor.line();
  const std::string_view encoding = in.cursor.word();
  if (encoding == "BINARY")
    in.encoding = Encoding::kBigEndian;
  else if (encoding != "ASCII")
    in.cursor.fail("ASCII or BINARY");
  in.format = fmt::format("VTK {}{}", first.substr(std::min(first.rfind(' ') + 1, first.size())),
                          in.encoding == Encoding::kText ? "" : " (binary)");
  if (in.cursor.peek_word() == "FIELD") in.cursor.word(), read_fields(in);
  in.cursor.expect("DATASET");
  in.cursor.expect(dataset);
}

void read_all(VtkReader& in, std::string_view dataset) {
  read_header(in, dataset);
  while (in.cursor.ok() && !in.cursor.at_end()) {
    skip_metadata(in.cursor);
    if (!in.cursor.at_end()) read_section(in, in.cursor.word());
  }
}

}  // namespace

Result<FoundSolid> parse_vtk(const fs::path& path, std::string_view bytes) {
  VtkReader in{.cursor = FileCursor(path, bytes)};
  read_all(in, "UNSTRUCTURED_GRID");
  if (in.cells.types.size() != in.cells.ends.size())
    in.cursor.fail(fmt::format("as many types as cells, {}", in.cells.ends.size()),
                   fmt::format("{}", in.cells.types.size()));
  if (!in.cells.regions.empty() && in.cells.regions.size() != in.cells.ends.size())
    in.cursor.fail(fmt::format("as many regions as cells, {}", in.cells.ends.size()),
                   fmt::format("{}", in.cells.regions.size()));
  if (!in.cursor.ok()) return in.cursor.error();
  in.cells.node_count = std::int64_t(in.points.size());
  FoundSolid found{.format = in.format, .nodes = std::move(in.points), .frame = in.frame};
  if (Status done = add_vtk_cells(found, in.cells); !done)
    return Error{fmt::format("{}: {}", path.string(), done.error().message)};
  return found;
}

Result<FoundSurface> parse_vtk_surface(const fs::path& path, std::string_view bytes) {
  VtkReader in{.cursor = FileCursor(path, bytes)};
  read_all(in, "POLYDATA");
  if (!in.cursor.ok()) return in.cursor.error();
  for (VtkCells* cells : {&in.surface.polygons, &in.surface.strips})
    cells->node_count = std::int64_t(in.points.size());
  FoundSurface found{.format = in.format, .vertices = std::move(in.points), .frame = in.frame};
  if (Status done = add_vtk_surface(found, in.surface); !done)
    return Error{fmt::format("{}: {}", path.string(), done.error().message)};
  note_left_out(found, in.surface.points, in.surface.lines);
  return found;
}

}  // namespace turgor::io
