// PLY, text and binary of both byte orders: positions of vertices and corners of faces; other elements and
// properties are skipped.
#include <array>
#include <utility>

#include <fmt/format.h>

#include "turgor/io/mesh/surface_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

struct Property {
  std::string name;
  bool is_list = false;
  NumberType count, type;  // type of a list's length; type of a value
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  Encoding encoding = Encoding::kText;
  std::vector<PlyElement> elements;
};

NumberType read_property_type(FileCursor& cursor) {
  using enum NumberType::Kind;
  static constexpr std::array<std::pair<std::string_view, NumberType>, 16> kTypes{{{"char", {kSigned, 1}},
                                                                                   {"int8", {kSigned, 1}},
                                                                                   {"uchar", {kUnsigned, 1}},
                                                                                   {"uint8", {kUnsigned, 1}},
                                                                                   {"short", {kSigned, 2}},
                                                                                   {"int16", {kSigned, 2}},
                                                                                   {"ushort", {kUnsigned, 2}},
                                                                                   {"uint16", {kUnsigned, 2}},
                                                                                   {"int", {kSigned, 4}},
                                                                                   {"int32", {kSigned, 4}},
                                                                                   {"uint", {kUnsigned, 4}},
                                                                                   {"uint32", {kUnsigned, 4}},
                                                                                   {"float", {kReal, 4}},
                                                                                   {"float32", {kReal, 4}},
                                                                                   {"double", {kReal, 8}},
                                                                                   {"float64", {kReal, 8}}}};
  const std::string_view name = cursor.word();
  for (const auto& [known, type] : kTypes)
    if (name == known) return type;
  cursor.fail("a type such as float or int");
  return {};
}

Encoding read_encoding(FileCursor& cursor) {
  const std::string_view name = cursor.word();
  if (name == "binary_little_endian") return Encoding::kLittleEndian;
  if (name == "binary_big_endian") return Encoding::kBigEndian;
  if (name != "ascii") cursor.fail("ascii, binary_little_endian or binary_big_endian");
  return Encoding::kText;
}

Property read_property(FileCursor& cursor) {
  Property property;
  property.is_list = cursor.peek_word() == "list";
  if (property.is_list) {
    cursor.word();
    property.count = read_property_type(cursor);
    if (property.count.kind == NumberType::kReal) cursor.fail("a whole type for the length of a list");
  }
  property.type = read_property_type(cursor);
  property.name = cursor.word();
  return property;
}

PlyHeader read_header(FileCursor& cursor) {
  PlyHeader header;
  cursor.line();  // "ply"
  while (cursor.ok()) {
    const std::string_view keyword = cursor.word();
    if (keyword == "end_header") break;
    if (keyword == "format")
      header.encoding = read_encoding(cursor);
    else if (keyword == "element")
      header.elements.push_back(
          {.name = std::string(cursor.word()), .count = cursor.count(0, {1, 1}, "a number of elements")});
    else if (keyword == "property" && !header.elements.empty())
      header.elements.back().properties.push_back(read_property(cursor));
    else if (keyword != "comment" && keyword != "obj_info")
      cursor.fail("element, property, comment or end_header");
    cursor.line();
  }
  cursor.line();
  return header;
}

/// Value of a property, or the values of its list.
void read_values(FileCursor& cursor, const Property& property, std::vector<double>& values) {
  values.clear();
  const std::int64_t count = property.is_list ? read_whole(cursor, property.count) : 1;
  if (count < 0) cursor.fail("the length of a list", fmt::format("{}", count));
  if (!cursor.can_hold(std::uint64_t(count), {1, std::size_t(property.type.bytes)}, "the length of a list"))
    return;
  for (std::int64_t n = 0; n < count && cursor.ok(); n++) values.push_back(read_real(cursor, property.type));
}

/// Calls take(property, values) for every property of every element, in the file's order.
template <class Take>
void read_elements(FileCursor& cursor, const PlyElement& element, const Take& take) {
  std::size_t bytes = 0;
  for (const Property& p : element.properties) bytes += std::size_t((p.is_list ? p.count : p.type).bytes);
  cursor.can_hold(element.count, {element.properties.size(), bytes}, "a number of elements");
  std::vector<double> values;
  for (std::size_t e = 0; e < element.count && cursor.ok(); e++)
    for (const Property& property : element.properties) {
      read_values(cursor, property, values);
      if (cursor.ok()) take(property, values);
    }
}

void read_vertices(FileCursor& cursor, const PlyElement& element, FoundSurface& found) {
  const Property* last = element.properties.empty() ? nullptr : &element.properties.back();
  Vec3d x;
  read_elements(cursor, element, [&](const Property& property, const std::vector<double>& values) {
    for (int axis = 0; axis < 3; axis++)
      if (property.name == std::string(1, "xyz"[axis]) && !values.empty()) x[axis] = values[0];
    if (&property == last) found.vertices.push_back(x);
  });
}

void read_faces(FileCursor& cursor, const PlyElement& element, FoundSurface& found) {
  read_elements(cursor, element, [&](const Property& property, const std::vector<double>& values) {
    if (property.name != "vertex_indices" && property.name != "vertex_index") return;
    if (values.size() < 3) cursor.fail("a face of at least 3 corners", fmt::format("{}", values.size()));
    for (const double value : values) {
      if (!(value >= 0 && value < 1e15)) cursor.fail("the number of a vertex", fmt::format("{}", value));
      if (cursor.ok()) found.corners.push_back(std::int64_t(value));
    }
    found.ends.push_back(found.corners.size());
  });
}

bool has_positions(const PlyElement& vertices) {
  int found = 0;
  for (const Property& p : vertices.properties)
    found += !p.is_list && (p.name == "x" || p.name == "y" || p.name == "z");
  return found == 3;
}

}  // namespace

Result<FoundSurface> parse_ply(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  const PlyHeader header = read_header(cursor);
  cursor.encoding = header.encoding;
  FoundSurface found{.format = header.encoding == Encoding::kText ? "PLY" : "PLY (binary)"};
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex" && !has_positions(element))
      cursor.fail("vertices with x, y and z", "others");
    if (element.name == "vertex")
      read_vertices(cursor, element, found);
    else if (element.name == "face")
      read_faces(cursor, element, found);
    else
      read_elements(cursor, element, [](const Property&, const std::vector<double>&) {});
  }
  if (!cursor.ok()) return cursor.error();
  return found;
}

}  // namespace turgor::io
