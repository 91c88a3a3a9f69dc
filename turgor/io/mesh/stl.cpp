// STL, text and binary: unconnected triangles, which are welded later.
#include <fmt/format.h>

#include "turgor/io/mesh/surface_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

void add_corner(Vec3d x, FoundSurface& found) {
  found.corners.push_back(std::int64_t(found.vertices.size()));
  found.vertices.push_back(x);
}

Vec3d read_position(FileCursor& cursor, int bytes) {
  Vec3d x;
  for (int axis = 0; axis < 3; axis++) x[axis] = cursor.real(bytes, "a coordinate");
  return x;
}

void expect(FileCursor& cursor, std::string_view word) {
  if (lower_case(cursor.word()) != word) cursor.fail(word);
}

/// Reads a facet after "facet": "normal" and three ignored numbers, "outer loop", three times "vertex" and a
/// position.
void read_facet(FileCursor& cursor, FoundSurface& found) {
  expect(cursor, "normal");
  for (int axis = 0; axis < 3; axis++) cursor.word();
  expect(cursor, "outer");
  expect(cursor, "loop");
  for (int corner = 0; corner < 3; corner++) {
    expect(cursor, "vertex");
    add_corner(read_position(cursor, 0), found);
  }
  expect(cursor, "endloop");
  expect(cursor, "endfacet");
  found.ends.push_back(found.corners.size());
}

}  // namespace

Result<FoundSurface> parse_stl_text(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  FoundSurface found{.format = "STL"};
  while (cursor.ok() && !cursor.at_end()) {
    expect(cursor, "solid");
    cursor.line();  // name
    while (cursor.ok() && lower_case(cursor.peek_word()) == "facet") {
      cursor.word();
      read_facet(cursor, found);
    }
    expect(cursor, "endsolid");
    cursor.line();
  }
  if (!cursor.ok()) return cursor.error();
  return found;
}

Result<FoundSurface> parse_stl_binary(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  cursor.encoding = Encoding::kLittleEndian;
  FoundSurface found{.format = "STL (binary)"};
  cursor.skip(80);
  const std::uint64_t count = cursor.unsigned_whole(4, "a number of triangles");
  cursor.can_hold(count, {12, 50}, "a number of triangles");
  for (std::uint64_t t = 0; t < count && cursor.ok(); t++) {
    cursor.skip(12);  // normal
    for (int corner = 0; corner < 3; corner++) add_corner(read_position(cursor, 4), found);
    cursor.skip(2);
    found.ends.push_back(found.corners.size());
  }
  if (!cursor.ok()) return cursor.error();
  return found;
}

}  // namespace turgor::io
