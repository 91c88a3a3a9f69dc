// VTU files: VTK's unstructured grids in XML, read by pugixml. Raw appended bytes are no XML: the text is cut
// before them.
#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <pugixml.hpp>

#include "turgor/io/vtk_cells.hpp"
#include "turgor/io/vtu_blocks.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

struct VtuFile {
  const fs::path& path;
  std::string_view bytes;
  std::string_view appended;  // from behind its "_"
  bool is_appended_base64 = false;
  pugi::xml_document xml;
};

Error error_at(const VtuFile& file, pugi::xml_node node, std::string_view message) {
  return {fmt::format("{}:{}: {}", file.path.string(),
                      line_of(file.bytes, std::size_t(std::max<std::ptrdiff_t>(node.offset_debug(), 0))),
                      message)};
}

Result<std::size_t> read_count(const VtuFile& file, pugi::xml_node node, const char* attribute) {
  std::int64_t value = 0;
  const std::string_view text = node.attribute(attribute).as_string();
  if (!parse_whole(text, value) || value < 0)
    return error_at(
        file, node,
        fmt::format("expected a number as {} of <{}>, found {}", attribute, node.name(), quoted(text)));
  return std::size_t(value);
}

std::optional<NumberType> type_named(std::string_view name) {
  for (const int bytes : {1, 2, 4, 8}) {
    if (name == fmt::format("Int{}", 8 * bytes)) return NumberType{NumberType::kSigned, bytes};
    if (name == fmt::format("UInt{}", 8 * bytes)) return NumberType{NumberType::kUnsigned, bytes};
    if (name == fmt::format("Float{}", 8 * bytes) && bytes >= 4) return NumberType{NumberType::kReal, bytes};
  }
  return {};
}

BlockFormat block_format(const VtuFile& file, bool is_base64) {
  const pugi::xml_node root = file.xml.child("VTKFile");
  return {.is_base64 = is_base64,
          .is_compressed = !root.attribute("compressor").empty(),
          .header_bytes = root.attribute("header_type").as_string() == std::string_view("UInt64") ? 8 : 4,
          .is_big_endian = root.attribute("byte_order").as_string() == std::string_view("BigEndian")};
}

/// Where the text between an array's tags begins and ends in the file.
std::pair<std::size_t, std::size_t> text_of(const VtuFile& file, pugi::xml_node array) {
  if (!array.first_child()) return {0, 0};
  const std::size_t begin = std::size_t(std::max<std::ptrdiff_t>(array.first_child().offset_debug(), 0));
  return {begin, std::min(file.bytes.find('<', begin), file.bytes.size())};
}

/// The bytes of an array that is not text.
Result<std::string> array_bytes(const VtuFile& file, pugi::xml_node array, std::size_t size) {
  const bool is_appended = array.attribute("format").as_string() == std::string_view("appended");
  const auto [begin, end] = text_of(file, array);
  std::string_view stored = file.bytes.substr(begin, end - begin);
  if (is_appended) {
    const Result<std::size_t> offset = read_count(file, array, "offset");
    if (!offset) return offset.error();
    stored = file.appended.substr(std::min(*offset, file.appended.size()));
  }
  const Result<std::string> bytes =
      read_block(stored, block_format(file, !is_appended || file.is_appended_base64), size);
  if (bytes) return bytes;
  return error_at(
      file, array,
      fmt::format("array {}: {}", quoted(array.attribute("Name").as_string()), bytes.error().message));
}

/// Calls take(cursor, type) `count` times: it reads one number of the array.
template <class Take>
Status read_array(const VtuFile& file, pugi::xml_node array, std::size_t count, const Take& take) {
  if (!array)
    return Error{
        fmt::format("{}: expected points, connectivity, offsets and types, found fewer", file.path.string())};
  const std::string_view type_name = array.attribute("type").as_string();
  const std::optional<NumberType> type = type_named(type_name);
  if (!type)
    return error_at(file, array, fmt::format("expected a type such as Float64, found {}", quoted(type_name)));
  const bool is_text = array.attribute("format").as_string("ascii") == std::string_view("ascii");
  const Result<std::string> bytes = is_text ? Result<std::string>(std::string{})
                                            : array_bytes(file, array, count * std::size_t(type->bytes));
  if (!bytes) return bytes.error();
  const auto [begin, end] = text_of(file, array);
  MeshCursor cursor(file.path, is_text ? file.bytes.substr(0, end) : std::string_view(*bytes));
  if (is_text)
    cursor.seek(begin);
  else
    cursor.encoding =
        block_format(file, false).is_big_endian ? Encoding::kBigEndian : Encoding::kLittleEndian;
  cursor.can_hold(count, {1, std::size_t(type->bytes)}, "a count of numbers");
  for (std::size_t i = 0; i < count && cursor.ok(); i++) take(cursor, *type);
  if (is_text && !cursor.at_end()) cursor.fail(fmt::format("{} numbers", count), "more");
  if (!cursor.ok()) return cursor.error();
  return Done{};
}

Status read_wholes(const VtuFile& file, pugi::xml_node array, std::size_t count,
                   std::vector<std::int64_t>& values) {
  return read_array(file, array, count,
                    [&](MeshCursor& cursor, NumberType type) { values.push_back(read_whole(cursor, type)); });
}

pugi::xml_node array_named(pugi::xml_node parent, const char* name) {
  return parent.find_child_by_attribute("DataArray", "Name", name);
}

Status read_points(const VtuFile& file, pugi::xml_node piece, std::size_t count, FoundSolid& found) {
  int axis = 0;
  return read_array(file, piece.child("Points").child("DataArray"), 3 * count,
                    [&](MeshCursor& cursor, NumberType type) {
                      if (axis == 0) found.nodes.emplace_back();
                      found.nodes.back()[axis] = read_real(cursor, type);
                      axis = (axis + 1) % 3;
                    });
}

Status read_regions(const VtuFile& file, pugi::xml_node piece, std::size_t count, VtkCells& cells) {
  pugi::xml_node best;
  int best_rank = 0;
  for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
    const int rank = region_rank(array.attribute("Name").as_string());
    if (rank <= best_rank || array.attribute("NumberOfComponents").as_int(1) != 1) continue;
    best_rank = rank;
    best = array;
  }
  if (!best) return Done{};
  return read_array(file, best, count, [&](MeshCursor& cursor, NumberType type) {
    cells.regions.push_back(read_real(cursor, type));
  });
}

/// A number of points or cells, within what the file can hold even when compressed.
Result<std::size_t> read_size(const VtuFile& file, pugi::xml_node piece, const char* attribute) {
  constexpr std::size_t kMostPacked = 1032;
  const Result<std::size_t> size = read_count(file, piece, attribute);
  if (size && *size > kMostPacked * file.bytes.size())
    return error_at(file, piece,
                    fmt::format("expected {} that the file can hold, found {}", attribute, *size));
  return size;
}

Status read_piece(const VtuFile& file, pugi::xml_node piece, std::int64_t first_cell, FoundSolid& found,
                  VtkCells& cells) {
  const Result<std::size_t> points = read_size(file, piece, "NumberOfPoints");
  if (!points) return points.error();
  const Result<std::size_t> count = read_size(file, piece, "NumberOfCells");
  if (!count) return count.error();
  cells.first_node = std::int64_t(found.nodes.size());
  cells.first_cell = first_cell;
  cells.node_count = std::int64_t(*points);
  const pugi::xml_node arrays = piece.child("Cells");
  if (Status done = read_points(file, piece, *points, found); !done) return done;
  if (Status done = read_wholes(file, array_named(arrays, "offsets"), *count, cells.ends); !done) return done;
  if (Status done = read_wholes(file, array_named(arrays, "types"), *count, cells.types); !done) return done;
  const std::int64_t corners = cells.ends.empty() ? 0 : cells.ends.back();
  if (corners < 0 || std::uint64_t(corners) > 1032 * file.bytes.size())
    return error_at(file, arrays, fmt::format("expected offsets that the file can hold, found {}", corners));
  if (Status done = read_wholes(file, array_named(arrays, "connectivity"), std::size_t(corners), cells.nodes);
      !done)
    return done;
  return read_regions(file, piece, *count, cells);
}

/// Cuts raw bytes off, which are no XML, and parses the rest.
Status parse_xml(VtuFile& file) {
  std::string text(file.bytes);
  const std::size_t appended = file.bytes.find("<AppendedData");
  if (appended != std::string_view::npos) {
    const std::size_t tag_end = file.bytes.find('>', appended), begin = file.bytes.find('_', tag_end);
    if (begin == std::string_view::npos)
      return Error{
          fmt::format("{}: expected \"_\" and bytes behind <AppendedData>, found the end of the file",
                      file.path.string())};
    const std::string_view tag = file.bytes.substr(appended, tag_end - appended);
    file.is_appended_base64 = tag.find("base64") != std::string_view::npos;
    file.appended = file.bytes.substr(begin + 1);
    text = std::string(file.bytes.substr(0, appended)) + "</VTKFile>";
  }
  const pugi::xml_parse_result parsed =
      file.xml.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed)
    return Error{fmt::format("{}:{}: expected XML, found a mistake: {}", file.path.string(),
                             line_of(text, std::size_t(parsed.offset)), parsed.description())};
  return Done{};
}

Status check_root(const VtuFile& file) {
  const pugi::xml_node root = file.xml.child("VTKFile");
  const std::string_view type = root.attribute("type").as_string(),
                         compressor = root.attribute("compressor").as_string();
  if (type != "UnstructuredGrid")
    return Error{fmt::format("{}: expected a VTKFile of type UnstructuredGrid, found {}", file.path.string(),
                             quoted(type))};
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    return Error{fmt::format("{}: expected no compression or vtkZLibDataCompressor, found {}",
                             file.path.string(), quoted(compressor))};
  return Done{};
}

std::string format_name(const VtuFile& file) {
  const bool is_compressed = block_format(file, false).is_compressed;
  return fmt::format("VTU{}", is_compressed ? " (compressed)" : "");
}

}  // namespace

Result<FoundSolid> parse_vtu(const fs::path& path, std::string_view bytes) {
  VtuFile file{.path = path, .bytes = bytes};
  if (Status done = parse_xml(file); !done) return done.error();
  if (Status done = check_root(file); !done) return done.error();
  FoundSolid found{.format = format_name(file)};
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
    found.notes.push_back(
        fmt::format("{} pieces lie side by side: points they share are not joined", pieces));
  return found;
}

}  // namespace turgor::io
