// Nodes and elements of Gmsh 1.0 and 2.0 to 2.2.
#include <fmt/format.h>

#include "turgor/io/mesh/gmsh.hpp"

namespace turgor::io {

namespace {

constexpr ItemSize kNode{4, 4 + 3 * 8};

void read_node(FileCursor& cursor, FoundSolid& found) {
  found.node_ids.push_back(cursor.whole(4, "the number of a node"));
  Vec3d x;
  for (int axis = 0; axis < 3; axis++) x[axis] = cursor.real(8, "a coordinate");
  found.nodes.push_back(x);
}

void read_nodes(FileCursor& cursor, std::size_t count, FoundSolid& found) {
  for (std::size_t n = 0; n < count && cursor.ok(); n++) read_node(cursor, found);
}

void read_corners(FileCursor& cursor, std::size_t count, std::vector<std::int64_t>& nodes) {
  nodes.clear();
  for (std::size_t n = 0; n < count && cursor.ok(); n++)
    nodes.push_back(cursor.whole(4, "the number of a node"));
}

/// Physical group, or the geometric entity without one.
std::int64_t region_of(std::int64_t physical, std::int64_t geometric) {
  return physical != 0 ? physical : geometric;
}

std::int64_t read_tags(FileCursor& cursor, std::size_t count) {
  std::int64_t tags[2] = {0, 0};
  for (std::size_t t = 0; t < count && cursor.ok(); t++) {
    const std::int64_t tag = cursor.whole(4, "a tag");
    if (t < 2) tags[t] = tag;
  }
  return region_of(tags[0], tags[1]);
}

/// Binary block of elements with the same type and number of tags.
std::size_t read_block(FileCursor& cursor, std::size_t most, FoundSolid& found) {
  const ElementType type = read_gmsh_type(cursor);
  const std::size_t count = cursor.count(4, {1, 4 * (1 + std::size_t(type.nodes))}, "a number of elements");
  const std::size_t tags = cursor.count(4, {1, 4}, "a number of tags");
  if (count == 0 || count > most)
    cursor.fail(fmt::format("1 to {} elements", most), fmt::format("{}", count));
  std::vector<std::int64_t> nodes;
  for (std::size_t e = 0; e < count && cursor.ok(); e++) {
    const std::int64_t id = cursor.whole(4, "the number of an element");
    const std::int64_t region = read_tags(cursor, tags);
    read_corners(cursor, std::size_t(type.nodes), nodes);
    if (cursor.ok()) add_element(found, type, id, region, nodes);
  }
  return count;
}

void read_line_element(FileCursor& cursor, std::vector<std::int64_t>& nodes, FoundSolid& found) {
  const std::int64_t id = cursor.whole(4, "the number of an element");
  const ElementType type = read_gmsh_type(cursor);
  const std::int64_t region = read_tags(cursor, cursor.count(4, {1, 4}, "a number of tags"));
  read_corners(cursor, std::size_t(type.nodes), nodes);
  if (cursor.ok()) add_element(found, type, id, region, nodes);
}

}  // namespace

void read_gmsh_1_nodes(FileCursor& cursor, FoundSolid& found) {
  read_nodes(cursor, cursor.count(4, kNode, "a number of nodes"), found);
  cursor.expect("$ENDNOD");
}

void read_gmsh_1_elements(FileCursor& cursor, FoundSolid& found) {
  const std::size_t count = cursor.count(4, {6, 24}, "a number of elements");
  std::vector<std::int64_t> nodes;
  for (std::size_t e = 0; e < count && cursor.ok(); e++) {
    const std::int64_t id = cursor.whole(4, "the number of an element");
    const ElementType type = read_gmsh_type(cursor);
    const std::int64_t physical = cursor.whole(4, "a region"), geometric = cursor.whole(4, "a region");
    if (cursor.whole(4, "a number of nodes") != type.nodes) cursor.fail(fmt::format("{} nodes", type.nodes));
    read_corners(cursor, std::size_t(type.nodes), nodes);
    if (cursor.ok()) add_element(found, type, id, region_of(physical, geometric), nodes);
  }
  cursor.expect("$ENDELM");
}

void read_gmsh_2_nodes(FileCursor& cursor, Encoding encoding, FoundSolid& found) {
  const std::size_t count = cursor.count(4, {1, 1}, "a number of nodes");  // text in binary files too
  if (encoding != Encoding::kText) cursor.line();
  cursor.encoding = encoding;
  if (cursor.can_hold(count, kNode, "a number of nodes")) read_nodes(cursor, count, found);
  cursor.encoding = Encoding::kText;
}

void read_gmsh_2_elements(FileCursor& cursor, Encoding encoding, FoundSolid& found) {
  const std::size_t count = cursor.count(4, {1, 1}, "a number of elements");
  if (encoding != Encoding::kText) cursor.line();
  cursor.encoding = encoding;
  std::vector<std::int64_t> nodes;
  for (std::size_t e = 0; e < count && cursor.ok();)
    if (encoding == Encoding::kText) {
      read_line_element(cursor, nodes, found);
      e++;
    } else {
      e += read_block(cursor, count - e, found);
    }
  cursor.encoding = Encoding::kText;
}

}  // namespace turgor::io
