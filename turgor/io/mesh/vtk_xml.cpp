#include "turgor/io/mesh/vtk_xml.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "turgor/io/mesh/mesh_frame.hpp"
#include "turgor/io/mesh/vtu_blocks.hpp"

namespace turgor::io {

namespace {

constexpr std::size_t kMostPacked = 1032;  // zlib's best ratio

Result<std::size_t> read_count(const VtkXml& file, pugi::xml_node node, const char* attribute) {
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

BlockFormat block_format(const VtkXml& file, bool is_base64) {
  const pugi::xml_node root = file.xml.child("VTKFile");
  return {.is_base64 = is_base64,
          .is_compressed = !root.attribute("compressor").empty(),
          .header_bytes = root.attribute("header_type").as_string() == std::string_view("UInt64") ? 8 : 4,
          .is_big_endian = root.attribute("byte_order").as_string() == std::string_view("BigEndian")};
}

/// Begin and end of the text between an array's tags in the file.
std::pair<std::size_t, std::size_t> text_of(const VtkXml& file, pugi::xml_node array) {
  if (!array.first_child()) return {0, 0};
  const std::size_t begin = std::size_t(std::max<std::ptrdiff_t>(array.first_child().offset_debug(), 0));
  return {begin, std::min(file.bytes.find('<', begin), file.bytes.size())};
}

/// Bytes of an array that is not text.
Result<std::string> array_bytes(const VtkXml& file, pugi::xml_node array, std::size_t size) {
  const bool is_appended = array.attribute("format").as_string() == std::string_view("appended");
  const auto [begin, end] = text_of(file, array);
  std::string_view stored = file.bytes.substr(begin, end - begin);
  if (is_appended) {
    const Result<std::size_t> offset = read_count(file, array, "offset");
    if (!offset) return offset.error();
    stored = file.appended.substr(std::min(*offset, file.appended.size()));
  }
  Result<std::string> bytes =
      read_block(stored, block_format(file, !is_appended || file.is_appended_base64), size);
  if (bytes) return bytes;
  return error_at(
      file, array,
      fmt::format("array {}: {}", quoted(array.attribute("Name").as_string()), bytes.error().message));
}

/// Calls take(cursor, type) for each number of an array.
Status read_array_numbers(const VtkXml& file, pugi::xml_node array, NumberType type, std::size_t count,
                          const std::function<void(FileCursor&, NumberType)>& take) {
  const bool is_text = array.attribute("format").as_string("ascii") == std::string_view("ascii");
  const Result<std::string> bytes = is_text ? Result<std::string>(std::string{})
                                            : array_bytes(file, array, count * std::size_t(type.bytes));
  if (!bytes) return bytes.error();
  const auto [begin, end] = text_of(file, array);
  FileCursor cursor(file.path, is_text ? file.bytes.substr(0, end) : std::string_view(*bytes));
  if (is_text)
    cursor.seek(begin);
  else
    cursor.encoding =
        block_format(file, false).is_big_endian ? Encoding::kBigEndian : Encoding::kLittleEndian;
  cursor.can_hold(count, {1, std::size_t(type.bytes)}, "a count of numbers");
  for (std::size_t i = 0; i < count && cursor.ok(); i++) take(cursor, type);
  if (is_text && !cursor.at_end()) cursor.fail(fmt::format("{} numbers", count), "more");
  if (!cursor.ok()) return cursor.error();
  return Done{};
}

/// Cuts raw appended bytes, which are not XML, and parses the rest.
Status parse_xml(VtkXml& file) {
  std::string text(file.bytes);
  const std::size_t appended = file.bytes.find("<AppendedData");
  if (appended != std::string_view::npos) {
    const std::size_t tag_end = file.bytes.find('>', appended), begin = file.bytes.find('_', tag_end);
    if (begin == std::string_view::npos)
      return Error{fmt::format("{}: expected \"_\" and bytes after <AppendedData>, found the end of the file",
                               file.path.string())};
    const std::string_view tag = file.bytes.substr(appended, tag_end - appended);
    file.is_appended_base64 = tag.find("base64") != std::string_view::npos;
    file.appended = file.bytes.substr(begin + 1);
    text = std::string(file.bytes.substr(0, appended)) + "</VTKFile>";
  }
  const pugi::xml_parse_result parsed =
      file.xml.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed)
    return Error{fmt::format("{}:{}: expected XML, found an error: {}", file.path.string(),
                             line_of(text, std::size_t(parsed.offset)), parsed.description())};
  return Done{};
}

Status check_root(const VtkXml& file, std::string_view expected) {
  const pugi::xml_node root = file.xml.child("VTKFile");
  const std::string_view type = root.attribute("type").as_string(),
                         compressor = root.attribute("compressor").as_string();
  if (type != expected)
    return Error{fmt::format("{}: expected a VTKFile of type {}, found {}", file.path.string(), expected,
                             quoted(type))};
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    return Error{fmt::format("{}: expected no compression or vtkZLibDataCompressor, found {}",
                             file.path.string(), quoted(compressor))};
  return Done{};
}

}  // namespace

Status parse_vtk_xml(VtkXml& file, std::string_view type) {
  if (Status done = parse_xml(file); !done) return done;
  return check_root(file, type);
}

std::string vtk_xml_format(const VtkXml& file, std::string_view name) {
  return fmt::format("{}{}", name, block_format(file, false).is_compressed ? " (compressed)" : "");
}

std::string vtk_xml_frame(const VtkXml& file) {
  const pugi::xml_node root = file.xml.child("VTKFile");
  for (const pugi::xml_node array : root.child(root.attribute("type").as_string()).child("FieldData")) {
    if (array.attribute("Name").as_string() != kFrameField) continue;
    constexpr std::size_t kLength = 4;  // three letters and a zero
    std::string name;
    const auto take = [&](FileCursor& cursor, NumberType type) { name += char(read_whole(cursor, type)); };
    const Status read = read_array_numbers(file, array, {NumberType::kUnsigned, 1}, kLength, take);
    return read ? name.substr(0, name.find('\0')) : "of another form";
  }
  return {};
}

Error error_at(const VtkXml& file, pugi::xml_node node, std::string_view message) {
  return {fmt::format("{}:{}: {}", file.path.string(),
                      line_of(file.bytes, std::size_t(std::max<std::ptrdiff_t>(node.offset_debug(), 0))),
                      message)};
}

Result<std::size_t> read_size(const VtkXml& file, pugi::xml_node piece, const char* attribute) {
  Result<std::size_t> size = read_count(file, piece, attribute);
  if (size && *size > kMostPacked * file.bytes.size())
    return error_at(file, piece,
                    fmt::format("expected {} that the file can hold, found {}", attribute, *size));
  return size;
}

pugi::xml_node array_named(pugi::xml_node parent, const char* name) {
  return parent.find_child_by_attribute("DataArray", "Name", name);
}

Status read_array(const VtkXml& file, pugi::xml_node array, std::size_t count,
                  const std::function<void(FileCursor&, NumberType)>& take) {
  if (!array)
    return Error{
        fmt::format("{}: expected points, connectivity, offsets and types, found fewer", file.path.string())};
  const std::string_view type_name = array.attribute("type").as_string();
  const std::optional<NumberType> type = type_named(type_name);
  if (!type)
    return error_at(file, array, fmt::format("expected a type such as Float64, found {}", quoted(type_name)));
  return read_array_numbers(file, array, *type, count, take);
}

Status read_wholes(const VtkXml& file, pugi::xml_node array, std::size_t count,
                   std::vector<std::int64_t>& values) {
  return read_array(file, array, count,
                    [&](FileCursor& cursor, NumberType type) { values.push_back(read_whole(cursor, type)); });
}

Status read_points(const VtkXml& file, pugi::xml_node piece, std::size_t count, std::vector<Vec3d>& points) {
  int axis = 0;
  return read_array(file, piece.child("Points").child("DataArray"), 3 * count,
                    [&](FileCursor& cursor, NumberType type) {
                      if (axis == 0) points.emplace_back();
                      points.back()[axis] = read_real(cursor, type);
                      axis = (axis + 1) % 3;
                    });
}

Status read_corners(const VtkXml& file, pugi::xml_node cells, std::size_t count,
                    std::vector<std::int64_t>& ends, std::vector<std::int64_t>& corners) {
  if (Status done = read_wholes(file, array_named(cells, "offsets"), count, ends); !done) return done;
  const std::int64_t last = ends.empty() ? 0 : ends.back();
  if (last < 0 || std::uint64_t(last) > kMostPacked * file.bytes.size())
    return error_at(file, cells, fmt::format("expected offsets that the file can hold, found {}", last));
  return read_wholes(file, array_named(cells, "connectivity"), std::size_t(last), corners);
}

}  // namespace turgor::io
