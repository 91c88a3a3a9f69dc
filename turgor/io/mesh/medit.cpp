// Medit files (.mesh), text: vertices, tetrahedra and hexahedra with their references; other sections are
// skipped.
#include <cctype>

#include <fmt/format.h>

#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

void read_vertices(FileCursor& cursor, FoundSolid& found) {
  const std::size_t count = cursor.count(0, {4, 0}, "a number of vertices");
  for (std::size_t n = 0; n < count && cursor.ok(); n++) {
    Vec3d x;
    for (int axis = 0; axis < 3; axis++) x[axis] = cursor.real(0, "a coordinate");
    cursor.word();  // reference
    found.node_ids.push_back(std::int64_t(found.nodes.size()) + 1);
    found.nodes.push_back(x);
  }
}

void read_elements(FileCursor& cursor, ElementType type, FoundSolid& found) {
  const std::size_t count = cursor.count(0, {std::size_t(type.nodes) + 1, 0}, "a number of elements");
  std::vector<std::int64_t> nodes(std::size_t(type.nodes));
  for (std::size_t e = 0; e < count && cursor.ok(); e++) {
    for (std::int64_t& node : nodes) node = cursor.whole(0, "the number of a vertex");
    const std::int64_t reference = cursor.whole(0, "a reference");
    if (cursor.ok()) add_element(found, type, std::int64_t(e) + 1, reference, nodes);
  }
}

bool is_keyword(std::string_view word) {
  return !word.empty() && std::isalpha(static_cast<unsigned char>(word.front()));
}

void skip_section(FileCursor& cursor) {
  while (cursor.ok() && !cursor.at_end() && !is_keyword(cursor.peek_word())) cursor.word();
}

void read_section(FileCursor& cursor, std::string_view keyword, FoundSolid& found) {
  if (keyword == "Vertices")
    read_vertices(cursor, found);
  else if (keyword == "Tetrahedra")
    read_elements(cursor, {Shape::kTet, 4}, found);
  else if (keyword == "Hexahedra")
    read_elements(cursor, {Shape::kHex, 8}, found);
  else if (keyword == "Prisms" || keyword == "Pyramids")
    found.other_solids += cursor.count(0, {6, 0}, "a number of elements"), skip_section(cursor);
  else if (keyword == "Dimension" && cursor.whole(0, "3 dimensions") != 3)
    cursor.fail("3 dimensions");
  else if (is_keyword(keyword))
    skip_section(cursor);
  else
    cursor.fail("a keyword such as Vertices or Tetrahedra");
}

}  // namespace

Result<FoundSolid> parse_medit(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  cursor.has_comments = true;
  FoundSolid found{.format = "Medit"};
  bool has_ended = false;
  while (cursor.ok() && !has_ended) {
    const std::string_view keyword = cursor.word();
    has_ended = keyword == "End" || keyword.empty();
    if (!has_ended) read_section(cursor, keyword, found);
  }
  if (!cursor.ok()) return cursor.error();
  return found;
}

}  // namespace turgor::io
