// Volumes, nodes and elements of Gmsh 4.1: one block per geometric entity.
#include <fmt/format.h>

#include "turgor/io/mesh/gmsh.hpp"

namespace turgor::io {

namespace {

constexpr int kInt = 4, kSize = 8, kReal = 8;  // bytes of the format's int, size_t and double

void skip_reals(FileCursor& cursor, int count) {
  for (int i = 0; i < count; i++) cursor.real(kReal, "a bound");
}

/// Reads the length and a list of tags; returns the first tag.
std::int64_t read_tags(FileCursor& cursor) {
  const std::size_t count = cursor.count(kSize, {1, kInt}, "a number of tags");
  std::int64_t first = 0;
  for (std::size_t i = 0; i < count && cursor.ok(); i++) {
    const std::int64_t tag = cursor.whole(kInt, "a tag");
    if (i == 0) first = tag;
  }
  return first;
}

void begin(FileCursor& cursor, Encoding encoding) {
  if (encoding != Encoding::kText) cursor.line();
  cursor.encoding = encoding;
}

int read_dimension(FileCursor& cursor) {
  const std::int64_t dimension = cursor.whole(kInt, "a dimension from 0 to 3");
  if (dimension < 0 || dimension > 3) cursor.fail("a dimension from 0 to 3", fmt::format("{}", dimension));
  return cursor.ok() ? int(dimension) : 0;
}

void read_node_block(FileCursor& cursor, FoundSolid& found) {
  const int dimension = read_dimension(cursor);
  cursor.whole(kInt, "a geometric entity");
  const bool is_parametric = cursor.whole(kInt, "0 or 1") != 0;
  const std::size_t count = cursor.count(kSize, {4, kSize + 3 * kReal}, "a number of nodes");
  for (std::size_t n = 0; n < count && cursor.ok(); n++)
    found.node_ids.push_back(cursor.whole(kSize, "the number of a node"));
  for (std::size_t n = 0; n < count && cursor.ok(); n++) {
    Vec3d x;
    for (int axis = 0; axis < 3; axis++) x[axis] = cursor.real(kReal, "a coordinate");
    if (is_parametric) skip_reals(cursor, dimension);
    found.nodes.push_back(x);
  }
}

/// Returns the number of elements.
std::size_t read_element_block(FileCursor& cursor, const GmshGroups& groups, FoundSolid& found) {
  const int dimension = read_dimension(cursor);
  const std::int64_t volume = cursor.whole(kInt, "a geometric entity");
  const ElementType type = read_gmsh_type(cursor);
  const std::size_t words = std::size_t(type.nodes) + 1;
  const std::size_t count = cursor.count(kSize, {words, words * kSize}, "a number of elements");
  const auto group = groups.find(volume);
  const std::int64_t region = dimension == 3 && group != groups.end() ? group->second : volume;
  std::vector<std::int64_t> nodes(std::size_t(type.nodes));
  for (std::size_t e = 0; e < count && cursor.ok(); e++) {
    const std::int64_t id = cursor.whole(kSize, "the number of an element");
    for (std::int64_t& node : nodes) node = cursor.whole(kSize, "the number of a node");
    if (cursor.ok()) add_element(found, type, id, region, nodes);
  }
  return count;
}

}  // namespace

void read_gmsh_4_entities(FileCursor& cursor, Encoding encoding, GmshGroups& groups) {
  begin(cursor, encoding);
  std::size_t counts[4] = {};
  for (std::size_t& count : counts)
    count = cursor.count(kSize, {5, kInt + 3 * kReal + kSize}, "a number of entities");
  for (int dimension = 0; dimension < 4; dimension++)
    for (std::size_t i = 0; i < counts[dimension] && cursor.ok(); i++) {
      const std::int64_t tag = cursor.whole(kInt, "a geometric entity");
      skip_reals(cursor, dimension == 0 ? 3 : 6);
      const std::int64_t group = read_tags(cursor);
      if (dimension > 0) read_tags(cursor);  // bounding entities
      if (dimension == 3 && group != 0) groups[tag] = group;
    }
  cursor.encoding = Encoding::kText;
}

void read_gmsh_4_nodes(FileCursor& cursor, Encoding encoding, FoundSolid& found) {
  begin(cursor, encoding);
  const std::size_t blocks = cursor.count(kSize, {4, 3 * kInt + kSize}, "a number of blocks");
  const std::size_t before = found.nodes.size(), count = cursor.count(kSize, {4, 32}, "a number of nodes");
  for (int i = 0; i < 2; i++) cursor.whole(kSize, "the number of a node");  // smallest, largest
  for (std::size_t b = 0; b < blocks && cursor.ok(); b++) read_node_block(cursor, found);
  if (found.nodes.size() - before != count)
    cursor.fail(fmt::format("{} nodes", count), fmt::format("{}", found.nodes.size() - before));
  cursor.encoding = Encoding::kText;
}

void read_gmsh_4_elements(FileCursor& cursor, Encoding encoding, const GmshGroups& groups,
                          FoundSolid& found) {
  begin(cursor, encoding);
  const std::size_t blocks = cursor.count(kSize, {4, 3 * kInt + kSize}, "a number of blocks");
  const std::size_t count = cursor.count(kSize, {2, 16}, "a number of elements");
  for (int i = 0; i < 2; i++) cursor.whole(kSize, "the number of an element");  // smallest, largest
  std::size_t read = 0;
  for (std::size_t b = 0; b < blocks && cursor.ok(); b++) read += read_element_block(cursor, groups, found);
  if (read != count) cursor.fail(fmt::format("{} elements", count), fmt::format("{}", read));
  cursor.encoding = Encoding::kText;
}

}  // namespace turgor::io
