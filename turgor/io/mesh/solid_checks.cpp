// Converts the elements of a file to a valid mesh: nodes by index, elements correctly oriented, none flat,
// none listed twice.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "turgor/geometry/repeated_elements.hpp"
#include "turgor/io/files/valid_position.hpp"
#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

constexpr double kFlat = 1e-12;  // of the median volume

const char* plural(int corners) { return corners == 4 ? "tetrahedra" : "hexahedra"; }

/// Maps a file's node numbers to indices.
class NodeIndex {
 public:
  explicit NodeIndex(const FoundSolid& found) : ids_(found.node_ids), count_(found.nodes.size()) {
    if (is_consecutive()) return;
    order_.resize(count_);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return ids_[a] < ids_[b]; });
  }

  std::int64_t id(std::size_t index) const { return ids_.empty() ? std::int64_t(index) : ids_[index]; }
  std::optional<std::int64_t> repeated() const {
    for (std::size_t i = 1; i < order_.size(); i++)
      if (ids_[order_[i]] == ids_[order_[i - 1]]) return ids_[order_[i]];
    return {};
  }
  std::optional<std::size_t> find(std::int64_t id) const {
    if (order_.empty()) {
      const std::uint64_t index = std::uint64_t(id) - std::uint64_t(count_ > 0 ? this->id(0) : 0);
      return index < count_ ? std::optional(std::size_t(index)) : std::nullopt;
    }
    const auto found = std::lower_bound(order_.begin(), order_.end(), id,
                                        [&](std::size_t a, std::int64_t value) { return ids_[a] < value; });
    return found != order_.end() && ids_[*found] == id ? std::optional(*found) : std::nullopt;
  }

 private:
  bool is_consecutive() const {
    for (std::size_t i = 1; i < ids_.size(); i++)
      if (ids_[i - 1] == std::numeric_limits<std::int64_t>::max() || ids_[i] != ids_[i - 1] + 1) return false;
    return true;
  }

  const std::vector<std::int64_t>& ids_;
  std::size_t count_;
  std::vector<std::size_t> order_;  // by id; empty if ids are consecutive
};

/// The first of a number of texts: "3, 7, 12, 20, 31 and 40 more".
template <class TextOf>
std::string some(std::size_t count, const TextOf& text_of) {
  constexpr std::size_t kShown = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(count, kShown); i++) text += (i > 0 ? ", " : "") + text_of(i);
  return count > kShown ? fmt::format("{} and {} more", text, count - kShown) : text;
}
std::string some(const std::vector<std::int64_t>& ids) {
  return some(ids.size(), [&](std::size_t i) { return std::to_string(ids[i]); });
}

Status check_positions(const fs::path& path, const FoundSolid& found, const NodeIndex& index, double scale) {
  if (const auto id = index.repeated())
    return Error{fmt::format("{}: expected every node once, found node {} twice", path.string(), *id)};
  for (std::size_t n = 0; n < found.nodes.size(); n++) {
    const Vec3d x = found.nodes[n];
    if (!is_valid_position(x * scale))
      return Error{fmt::format("{}: node {}: expected finite coordinates below 1e9 m, found ({}, {}, {})",
                               path.string(), index.id(n), x.x, x.y, x.z)};
  }
  return Done{};
}

/// Converts node numbers of elements to indices.
Status connect(const fs::path& path, const FoundElements& elements, const NodeIndex& index, SolidMesh& mesh) {
  const std::size_t corners = std::size_t(mesh.corners);
  if (elements.nodes.size() > std::size_t(std::numeric_limits<int>::max()))
    return Error{fmt::format("{}: expected fewer than {} {}, found {}", path.string(),
                             std::size_t(std::numeric_limits<int>::max()) / corners, plural(mesh.corners),
                             elements.ids.size())};
  for (std::size_t i = 0; i < elements.nodes.size(); i++) {
    const std::optional<std::size_t> node = index.find(elements.nodes[i]);
    if (!node || *node > std::size_t(std::numeric_limits<int>::max()))
      return Error{
          fmt::format("{}: element {}: expected the number of a node, found {}, which does not exist",
                      path.string(), elements.ids[i / corners], elements.nodes[i])};
    mesh.elements.push_back(int(*node));
  }
  for (const std::int64_t region : elements.regions) {
    if (region != int(region))
      return Error{fmt::format("{}: expected regions of at most {}, found {}", path.string(),
                               std::numeric_limits<int>::max(), region)};
    mesh.regions.push_back(int(region));
  }
  if (std::all_of(mesh.regions.begin(), mesh.regions.end(), [](int r) { return r == 0; })) mesh.regions = {};
  return Done{};
}

/// Keeps the nodes that elements use, in their order; returns the number of dropped nodes.
std::size_t drop_unused(const FoundSolid& found, double scale, SolidMesh& mesh) {
  std::vector<int> number(found.nodes.size(), -1);
  for (const int v : mesh.elements) number[std::size_t(v)] = 0;
  for (std::size_t n = 0; n < number.size(); n++)
    if (number[n] == 0) {
      number[n] = int(mesh.vertices.size());
      mesh.vertices.push_back(found.nodes[n] * scale);
    }
  for (int& v : mesh.elements) v = number[std::size_t(v)];
  return found.nodes.size() - mesh.vertices.size();
}

/// Error if an element is listed twice. Both copies would weigh, and their faces would not be on the surface.
Status check_repeated(const fs::path& path, const SolidMesh& mesh, const std::vector<std::int64_t>& ids) {
  const std::vector<RepeatedElement> repeated = repeated_elements(mesh);
  if (repeated.empty()) return Done{};
  const std::string text = some(repeated.size(), [&](std::size_t i) {
    return fmt::format("{} repeats {}", ids[repeated[i].again], ids[repeated[i].first]);
  });
  return Error{
      fmt::format("{}: expected every element once, found {} of {} {} with the corners of another: {}",
                  path.string(), repeated.size(), ids.size(), plural(mesh.corners), text)};
}

/// Mirrors an element by exchanging two corners of a tetrahedron, or bottom and top of a hexahedron.
void turn(SolidMesh& mesh, std::size_t e) {
  const auto corner = mesh.elements.begin() + std::ptrdiff_t(e) * mesh.corners;
  if (mesh.corners == 4)
    std::swap(corner[0], corner[1]);
  else
    std::swap_ranges(corner, corner + 4, corner + 4);
}

/// True if a hexahedron is inverted at one of its corners.
bool is_twisted(const SolidMesh& mesh, std::size_t e) {
  static constexpr std::size_t kNext[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                              {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
  const auto x = [&](std::size_t c) { return mesh.vertices[std::size_t(element(mesh, e)[c])]; };
  for (std::size_t c = 0; c < 8; c++)
    if (orientation(x(c), x(kNext[c][0]), x(kNext[c][1]), x(kNext[c][2])) <= 0) return true;
  return false;
}

struct Wrong {
  std::vector<std::int64_t> turned, flat, twisted;
};

/// Reorients inverted elements. Reports elements that cannot be repaired: flat ones, and hexahedra that are
/// inverted at some of their corners.
Wrong repair(SolidMesh& mesh, const std::vector<std::int64_t>& ids) {
  Wrong wrong;
  std::vector<double> volumes(ids.size());
  for (std::size_t e = 0; e < ids.size(); e++) volumes[e] = volume(mesh, e);
  std::vector<double> sizes = volumes;
  for (double& v : sizes) v = std::abs(v);
  const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  for (std::size_t e = 0; e < ids.size(); e++) {
    if (std::abs(volumes[e]) <= kFlat * *middle) {
      wrong.flat.push_back(ids[e]);
      continue;
    }
    if (volumes[e] < 0) {
      turn(mesh, e);
      wrong.turned.push_back(ids[e]);
    }
    if (mesh.corners == 8 && is_twisted(mesh, e)) wrong.twisted.push_back(ids[e]);
  }
  return wrong;
}

void add_notes(const FoundSolid& found, const Wrong& wrong, std::size_t unused, ReadSolid& read) {
  const SolidMesh& mesh = read.mesh;
  if (!wrong.turned.empty())
    read.notes.push_back(fmt::format("{} of {} {} were inverted and have been reoriented: {}",
                                     wrong.turned.size(), element_count(mesh), plural(mesh.corners),
                                     some(wrong.turned)));
  if (found.curved > 0)
    read.notes.push_back(
        fmt::format("only the corner nodes of {} are used", counted(found.curved, "element")));
  const std::size_t left_out = found.other_solids + (mesh.corners == 4 ? found.hexes.ids.size() : 0);
  if (left_out > 0)
    read.notes.push_back(
        fmt::format("ignored: {} other than {}", counted(left_out, "solid element"), plural(mesh.corners)));
  if (unused > 0 && found.curved == 0)
    read.notes.push_back(fmt::format("dropped: {} that no element uses", counted(unused, "node")));
}

}  // namespace

void add_element(FoundSolid& found, ElementType type, std::int64_t id, std::int64_t region,
                 std::span<const std::int64_t> nodes) {
  if (type.shape == Shape::kOtherSolid) found.other_solids++;
  const std::size_t corners = std::size_t(corners_of(type.shape));
  if (corners == 0) return;
  FoundElements& elements = corners == 4 ? found.tets : found.hexes;
  elements.ids.push_back(id);
  elements.regions.push_back(region);
  elements.nodes.insert(elements.nodes.end(), nodes.begin(), nodes.begin() + std::ptrdiff_t(corners));
  found.curved += nodes.size() > corners;
  if (type.shape != Shape::kVoxel) return;
  const auto last = elements.nodes.end();
  std::swap(last[-1], last[-2]);  // a voxel's corners are ordered by x, then y, then z
  std::swap(last[-5], last[-6]);
}

Result<ReadSolid> finish_solid(const fs::path& path, const FoundSolid& found, double scale) {
  const FoundElements& elements = found.tets.ids.empty() ? found.hexes : found.tets;
  if (elements.ids.empty())
    return Error{fmt::format("{}: expected tetrahedra or hexahedra, found none in this {} file",
                             path.string(), found.format)};
  ReadSolid read{.format = found.format, .notes = found.notes};
  read.mesh.corners = &elements == &found.tets ? 4 : 8;
  const NodeIndex index(found);
  if (Status done = check_positions(path, found, index, scale); !done) return done.error();
  if (Status done = connect(path, elements, index, read.mesh); !done) return done.error();
  const std::size_t unused = drop_unused(found, scale, read.mesh);
  const Wrong wrong = repair(read.mesh, elements.ids);
  if (!wrong.flat.empty())
    return Error{fmt::format("{}: expected {} with a volume, found {} flat: {}", path.string(),
                             plural(read.mesh.corners), wrong.flat.size(), some(wrong.flat))};
  if (!wrong.twisted.empty())
    return Error{fmt::format("{}: expected convex hexahedra, found {} inverted at a corner: {}",
                             path.string(), wrong.twisted.size(), some(wrong.twisted))};
  if (Status done = check_repeated(path, read.mesh, elements.ids); !done) return done.error();
  read.inverted = wrong.turned.size();
  add_notes(found, wrong, unused, read);
  return read;
}

}  // namespace turgor::io
