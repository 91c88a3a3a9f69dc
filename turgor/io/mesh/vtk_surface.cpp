#include "turgor/io/mesh/vtk_surface.hpp"

#include <span>

#include <fmt/format.h>

namespace turgor::io {

namespace {

/// Corners of one cell, checked.
Result<std::span<const std::int64_t>> corners_of_cell(const VtkCells& cells, std::size_t c) {
  const std::int64_t begin = c > 0 ? cells.ends[c - 1] : 0, end = cells.ends[c],
                     last = std::int64_t(cells.nodes.size());
  if (end < begin || end > last)
    return Error{fmt::format("expected its points to end between {} and {}, found {}", begin, last, end)};
  if (end - begin < 3) return Error{fmt::format("expected at least 3 points, found {}", end - begin)};
  const std::span<const std::int64_t> corners(cells.nodes.data() + begin, std::size_t(end - begin));
  for (const std::int64_t v : corners)
    if (v < 0 || v >= cells.node_count)
      return Error{fmt::format("expected points from 0 to {}, found {}", cells.node_count - 1, v)};
  return corners;
}

void add_polygon(FoundSurface& found, std::span<const std::int64_t> corners, std::int64_t first_node) {
  for (const std::int64_t v : corners) found.corners.push_back(v + first_node);
  found.ends.push_back(found.corners.size());
}

/// Adds a triangle strip: every point forms a triangle with the two before it, with alternating orientation.
void add_strip(FoundSurface& found, std::span<const std::int64_t> corners, std::int64_t first_node) {
  for (std::size_t i = 2; i < corners.size(); i++) {
    const std::size_t odd = i % 2;
    const std::int64_t triangle[] = {corners[i - 2], corners[i - 1 + odd], corners[i - odd]};
    add_polygon(found, triangle, first_node);
  }
}

template <class Add>
Status add_cells(FoundSurface& found, const VtkCells& cells, const char* name, const Add& add) {
  for (std::size_t c = 0; c < cells.ends.size(); c++) {
    const Result<std::span<const std::int64_t>> corners = corners_of_cell(cells, c);
    if (!corners) return Error{fmt::format("{} {}: {}", name, c, corners.error().message)};
    add(found, *corners, cells.first_node);
  }
  return Done{};
}

}  // namespace

Status add_vtk_surface(FoundSurface& found, const VtkSurface& surface) {
  if (Status done = add_cells(found, surface.polygons, "polygon", add_polygon); !done) return done;
  return add_cells(found, surface.strips, "strip", add_strip);
}

void note_left_out(FoundSurface& found, std::size_t points, std::size_t lines) {
  if (points > 0) found.notes.push_back(fmt::format("ignored: {}", counted(points, "single point")));
  if (lines > 0) found.notes.push_back(fmt::format("ignored: {}", counted(lines, "line")));
}

}  // namespace turgor::io
