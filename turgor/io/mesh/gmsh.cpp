// Gmsh files: the version and the relevant sections; other sections are skipped.
#include "turgor/io/mesh/gmsh.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

struct Version {
  int major = 1;  // 1, 2 (2.0 to 2.2) or 4 (4.1)
  Encoding encoding = Encoding::kText;
  std::string name = "Gmsh 1.0";
};

/// Reads the line after "$MeshFormat": version, 0 for text or 1 for binary, bytes per number. Binary files
/// add the number 1, which shows the byte order.
Version read_version(FileCursor& cursor) {
  Version version;
  const std::string text(cursor.word());
  if (text == "4.1")
    version.major = 4;
  else if (text == "2" || text == "2.0" || text == "2.1" || text == "2.2")
    version.major = 2;
  else
    cursor.fail("Gmsh version 2.0, 2.1, 2.2 or 4.1 (save it with -format msh41)");
  const std::int64_t is_binary = cursor.whole(4, "0 (text) or 1 (binary)");
  if (is_binary != 0 && is_binary != 1) cursor.fail("0 (text) or 1 (binary)");
  if (cursor.whole(4, "8 bytes a number") != 8) cursor.fail("8 bytes a number");
  version.name = fmt::format("Gmsh {}{}", text, is_binary == 1 ? " (binary)" : "");
  if (is_binary == 0) return version;
  cursor.line();
  const std::string_view one = cursor.skip(4);
  if (one == std::string_view("\1\0\0\0", 4))
    version.encoding = Encoding::kLittleEndian;
  else if (one == std::string_view("\0\0\0\1", 4))
    version.encoding = Encoding::kBigEndian;
  else
    cursor.fail("the number 1 in four bytes, which tells their order", "something else");
  return version;
}

/// Skips an unused section, which may be binary.
void skip_section(FileCursor& cursor, std::string_view name) {
  const std::string end = fmt::format("$End{}", name.substr(1));
  const std::size_t found = cursor.bytes().find(end, cursor.offset());
  if (found == std::string_view::npos) return cursor.fail(end, "the end of the file");
  cursor.seek(found);
  cursor.expect(end);
}

void read_section(FileCursor& cursor, std::string_view name, const Version& version, GmshGroups& groups,
                  FoundSolid& found) {
  if (name == "$NOD") return read_gmsh_1_nodes(cursor, found);
  if (name == "$ELM") return read_gmsh_1_elements(cursor, found);
  if (version.major == 1 || (name != "$Entities" && name != "$Nodes" && name != "$Elements"))
    return skip_section(cursor, name);
  if (name == "$Entities")
    read_gmsh_4_entities(cursor, version.encoding, groups);
  else if (name == "$Nodes")
    version.major == 4 ? read_gmsh_4_nodes(cursor, version.encoding, found)
                       : read_gmsh_2_nodes(cursor, version.encoding, found);
  else
    version.major == 4 ? read_gmsh_4_elements(cursor, version.encoding, groups, found)
                       : read_gmsh_2_elements(cursor, version.encoding, found);
  cursor.expect(fmt::format("$End{}", name.substr(1)));
}

}  // namespace

ElementType read_gmsh_type(FileCursor& cursor) {
  using enum Shape;
  // points, lines, surfaces; solids of order 1, 2 and higher, with and without interior nodes
  static constexpr std::array<ElementType, 32> kTypes{{
      {},
      {kPointLineOrSurface, 2},
      {kPointLineOrSurface, 3},
      {kPointLineOrSurface, 4},
      {kTet, 4},
      {kHex, 8},
      {kOtherSolid, 6},
      {kOtherSolid, 5},
      {kPointLineOrSurface, 3},
      {kPointLineOrSurface, 6},
      {kPointLineOrSurface, 9},
      {kTet, 10},
      {kHex, 27},
      {kOtherSolid, 18},
      {kOtherSolid, 14},
      {kPointLineOrSurface, 1},
      {kPointLineOrSurface, 8},
      {kHex, 20},
      {kOtherSolid, 15},
      {kOtherSolid, 13},
      {kPointLineOrSurface, 9},
      {kPointLineOrSurface, 10},
      {kPointLineOrSurface, 12},
      {kPointLineOrSurface, 15},
      {kPointLineOrSurface, 15},
      {kPointLineOrSurface, 21},
      {kPointLineOrSurface, 4},
      {kPointLineOrSurface, 5},
      {kPointLineOrSurface, 6},
      {kTet, 20},
      {kTet, 35},
      {kTet, 56},
  }};
  constexpr std::int64_t kLast = std::int64_t(kTypes.size()) - 1, kLastOfGmsh = 140;
  const std::int64_t number = cursor.whole(4, "the type of an element");
  if (number > 0 && number <= kLast) return kTypes[std::size_t(number)];
  const bool is_other = number > kLast && number <= kLastOfGmsh;
  cursor.fail(
      fmt::format("one of Gmsh's element types 1 to {}", kLast),
      fmt::format(
          "{}{}", number,
          is_other ? ", of a higher order or another shape; gmsh -order 1 writes types that are read" : ""));
  return {};
}

Result<FoundSolid> parse_gmsh(const fs::path& path, std::string_view bytes) {
  FileCursor cursor(path, bytes);
  Version version;
  GmshGroups groups;
  FoundSolid found;
  while (cursor.ok() && !cursor.at_end()) {
    const std::string_view name = cursor.word();
    if (!name.starts_with("$"))
      cursor.fail("a section such as $Nodes");
    else if (name == "$MeshFormat") {
      version = read_version(cursor);
      cursor.expect("$EndMeshFormat");
    } else
      read_section(cursor, name, version, groups, found);
  }
  if (!cursor.ok()) return cursor.error();
  found.format = version.name;
  return found;
}

}  // namespace turgor::io
