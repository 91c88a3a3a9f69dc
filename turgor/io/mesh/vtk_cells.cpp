#include "turgor/io/mesh/vtk_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace turgor::io {

namespace {

/// VTK's cell types; 0 nodes if their number varies.
ElementType vtk_type(std::int64_t number) {
  switch (number) {
    case 10:
      return {Shape::kTet, 4};
    case 24:
      return {Shape::kTet, 10};
    case 71:
      return {Shape::kTet, 0};  // Lagrange
    case 11:
      return {Shape::kVoxel, 8};
    case 12:
      return {Shape::kHex, 8};
    case 25:
      return {Shape::kHex, 20};
    case 29:
      return {Shape::kHex, 27};
    case 72:
      return {Shape::kHex, 0};
    case 13:
    case 14:
    case 26:
    case 27:
    case 42:
    case 73:
    case 74:
      return {Shape::kOtherSolid, 0};
    default:
      return {Shape::kPointLineOrSurface, 0};
  }
}

Status check_cell(const VtkCells& cells, std::size_t c, std::int64_t begin, std::int64_t end) {
  const std::int64_t last = std::int64_t(cells.nodes.size());
  if (end < begin || end > last)
    return Error{fmt::format("expected its nodes to end between {} and {}, found {}", begin, last, end)};
  const ElementType type = vtk_type(cells.types[c]);
  const std::int64_t count = end - begin, least = type.nodes > 0 ? type.nodes : corners_of(type.shape);
  if (type.nodes > 0 ? count != least : count < least)
    return Error{
        fmt::format("expected {} nodes for a cell of type {}, found {}", least, cells.types[c], count)};
  for (std::int64_t n = begin; n < end; n++)
    if (cells.nodes[std::size_t(n)] < 0 || cells.nodes[std::size_t(n)] >= cells.node_count)
      return Error{fmt::format("expected points from 0 to {}, found {}", cells.node_count - 1,
                               cells.nodes[std::size_t(n)])};
  return Done{};
}

bool are_whole(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](double v) { return v == std::floor(v) && std::abs(v) < 1e9; });
}

}  // namespace

int region_rank(std::string_view name) {
  constexpr std::array<std::string_view, 13> kNames{
      "region",    "regions",     "gmsh:physical", "medit:ref", "cell_tags", "cellentityids", "material",
      "materials", "materialids", "label",         "labels",    "tag",       "attribute"};
  return int(kNames.end() - std::find(kNames.begin(), kNames.end(), lower_case(name)));
}

Status add_vtk_cells(FoundSolid& found, const VtkCells& cells) {
  const bool has_regions = !cells.regions.empty() && are_whole(cells.regions);
  if (!cells.regions.empty() && !has_regions)
    found.notes.push_back("the regions of cells are not integers and were ignored");
  std::vector<std::int64_t> nodes;
  for (std::size_t c = 0; c < cells.ends.size(); c++) {
    const std::int64_t id = cells.first_cell + std::int64_t(c);
    const std::int64_t begin = c > 0 ? cells.ends[c - 1] : 0, end = cells.ends[c];
    if (Status done = check_cell(cells, c, begin, end); !done)
      return Error{fmt::format("cell {}: {}", id, done.error().message)};
    nodes.assign(cells.nodes.begin() + begin, cells.nodes.begin() + end);
    for (std::int64_t& node : nodes) node += cells.first_node;
    add_element(found, vtk_type(cells.types[c]), id, has_regions ? std::int64_t(cells.regions[c]) : 0, nodes);
  }
  return Done{};
}

}  // namespace turgor::io
