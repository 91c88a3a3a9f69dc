// Wavefront OBJ: positions of vertices and faces; normals, textures, groups and materials are skipped.
#include <fmt/format.h>

#include "turgor/io/mesh/surface_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

/// Next word of a line; empty at its end.
std::string_view next_word(std::string_view& line) {
  constexpr std::string_view kSpace = " \t\v\f\r";
  const std::size_t begin = std::min(line.find_first_not_of(kSpace), line.size());
  const std::size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

std::string shown(std::string_view word) {
  return word.empty() ? std::string("the end of the line") : quoted(word);
}

void read_vertex(FileCursor& cursor, std::string_view line, FoundSurface& found) {
  Vec3d x;
  for (int axis = 0; axis < 3; axis++) {
    const std::string_view word = next_word(line);
    if (!parse_real(word, x[axis])) cursor.fail("a coordinate", shown(word));
  }
  found.vertices.push_back(x);
}

/// Corners are "vertex", "vertex/texture", "vertex//normal" or all three, counted from 1, or backwards from
/// -1.
void read_face(FileCursor& cursor, std::string_view line, FoundSurface& found) {
  std::size_t count = 0;
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line), count++) {
    std::int64_t number = 0;
    const bool is_number = parse_whole(word.substr(0, word.find('/')), number) && number != 0;
    const std::int64_t vertices = std::int64_t(found.vertices.size());
    if (!is_number || number < -vertices) return cursor.fail("the number of a vertex", quoted(word));
    found.corners.push_back(number > 0 ? number - 1 : vertices + number);
  }
  if (count < 3) cursor.fail("a face of at least 3 corners", fmt::format("{}", count));
  found.ends.push_back(found.corners.size());
}

}  // namespace

Result<FoundSurface> parse_obj(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  FoundSurface found{.format = "OBJ", .first = 1};
  std::string joined;
  while (cursor.ok() && cursor.offset() < bytes.size()) {
    std::string_view line = cursor.line();
    if (line.ends_with('\\')) {  // continued in the next line
      joined.clear();
      for (; line.ends_with('\\'); line = cursor.line())
        joined.append(line.substr(0, line.size() - 1)) += ' ';
      line = joined.append(line);
    }
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") read_vertex(cursor, line, found);
    if (keyword == "f") read_face(cursor, line, found);
  }
  if (!cursor.ok()) return cursor.error();
  return found;
}

}  // namespace turgor::io
