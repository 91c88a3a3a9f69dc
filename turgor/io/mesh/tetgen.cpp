// TetGen's pair of files: points (.node) and tetrahedra (.ele), counted from 0 or from 1.
#include <cmath>

#include <fmt/format.h>

#include "turgor/io/mesh/mesh_bytes.hpp"
#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

FileCursor cursor_of(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  cursor.has_comments = true;
  return cursor;
}

/// Reads "count, 3, attributes, markers", then one line per point: number, x, y, z, attributes, marker.
Status read_points(const fs::path& path, std::string_view bytes, FoundSolid& found) {
  FileCursor cursor = cursor_of(path, bytes);
  const std::size_t count = cursor.count(0, {4, 0}, "a number of points");
  if (cursor.whole(0, "3 dimensions") != 3) cursor.fail("3 dimensions");
  const std::size_t attributes = cursor.count(0, {1, 0}, "a number of attributes");
  const std::int64_t markers = cursor.whole(0, "0 or 1 markers");
  if (markers != 0 && markers != 1) cursor.fail("0 or 1 markers");
  for (std::size_t n = 0; n < count && cursor.ok(); n++) {
    found.node_ids.push_back(cursor.whole(0, "the number of a point"));
    Vec3d x;
    for (int axis = 0; axis < 3; axis++) x[axis] = cursor.real(0, "a coordinate");
    found.nodes.push_back(x);
    for (std::size_t a = 0; a < attributes + std::size_t(markers) && cursor.ok(); a++)
      cursor.real(0, "an attribute");
  }
  if (!cursor.ok()) return cursor.error();
  return Done{};
}

/// First attribute as a region; TetGen writes it as a real number.
std::int64_t read_region(FileCursor& cursor, std::size_t attributes) {
  double region = 0;
  for (std::size_t a = 0; a < attributes && cursor.ok(); a++) {
    const double attribute = cursor.real(0, "a region");
    if (!(std::abs(attribute) < 1e9)) cursor.fail("a region");
    if (a == 0 && cursor.ok()) region = attribute;
  }
  return std::llround(region);
}

/// Reads "count, nodes each (4 or 10), attributes", then one line per tetrahedron: number, nodes, attributes.
Status read_tets(const fs::path& path, std::string_view bytes, FoundSolid& found) {
  FileCursor cursor = cursor_of(path, bytes);
  const std::size_t count = cursor.count(0, {5, 0}, "a number of tetrahedra");
  const std::int64_t corners = cursor.whole(0, "4 or 10 nodes a tetrahedron");
  if (corners != 4 && corners != 10) cursor.fail("4 or 10 nodes a tetrahedron");
  const std::size_t attributes = cursor.count(0, {1, 0}, "a number of attributes");
  const ElementType type{Shape::kTet, int(corners)};
  std::vector<std::int64_t> nodes(cursor.ok() ? std::size_t(corners) : 0);
  for (std::size_t e = 0; e < count && cursor.ok(); e++) {
    const std::int64_t id = cursor.whole(0, "the number of a tetrahedron");
    for (std::int64_t& node : nodes) node = cursor.whole(0, "the number of a point");
    const std::int64_t region = read_region(cursor, attributes);
    if (cursor.ok()) add_element(found, type, id, region, nodes);
  }
  if (!cursor.ok()) return cursor.error();
  return Done{};
}

/// True if the file holds points: its second number is 3, the dimensions.
bool holds_points(std::string_view bytes) {
  FileCursor cursor = cursor_of("", bytes);
  cursor.word();
  return cursor.word() == "3";
}

}  // namespace

Result<FoundSolid> parse_tetgen(const fs::path& path, std::string_view bytes) {
  const bool is_points = holds_points(bytes);
  fs::path other = path;
  other.replace_extension(is_points ? ".ele" : ".node");
  std::error_code failed;
  if (!fs::exists(other, failed))
    return Error{fmt::format("{}: does not exist: expected the {} that belong to {}", other.string(),
                             is_points ? "tetrahedra" : "points", path.string())};
  const Result<std::string> rest = read_mesh_bytes(other);
  if (!rest) return rest.error();
  FoundSolid found{.format = "TetGen"};
  if (Status done = read_points(is_points ? path : other, is_points ? bytes : *rest, found); !done)
    return done.error();
  if (Status done = read_tets(is_points ? other : path, is_points ? *rest : bytes, found); !done)
    return done.error();
  return found;
}

}  // namespace turgor::io
