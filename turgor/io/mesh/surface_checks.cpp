// Converts the polygons of a file to triangles: coincident vertices are welded, degenerate triangles dropped.
#include <limits>

#include <fmt/format.h>

#include "turgor/geometry/weld.hpp"
#include "turgor/io/files/valid_position.hpp"
#include "turgor/io/mesh/polygon.hpp"
#include "turgor/io/mesh/surface_formats.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

Status check_positions(const fs::path& path, const FoundSurface& found, double scale) {
  for (std::size_t v = 0; v < found.vertices.size(); v++) {
    const Vec3d x = found.vertices[v];
    if (!is_valid_position(x * scale))
      return Error{fmt::format("{}: vertex {}: expected finite coordinates below 1e9 m, found ({}, {}, {})",
                               path.string(), v + std::size_t(found.first), x.x, x.y, x.z)};
  }
  if (found.vertices.size() > std::size_t(std::numeric_limits<int>::max()))
    return Error{fmt::format("{}: expected at most {} vertices, found {}", path.string(),
                             std::numeric_limits<int>::max(), found.vertices.size())};
  return Done{};
}

/// Triangles of one polygon, by the file's vertices.
Status triangulate_polygon(const fs::path& path, const FoundSurface& found, std::size_t polygon,
                           std::vector<Int3>& triangles) {
  const std::size_t begin = polygon > 0 ? found.ends[polygon - 1] : 0, count = found.ends[polygon] - begin;
  const std::int64_t vertices = std::int64_t(found.vertices.size());
  std::vector<Vec3d> corners;
  for (std::size_t c = 0; c < count; c++) {
    const std::int64_t v = found.corners[begin + c];
    if (v < 0 || v >= vertices)
      return Error{fmt::format("{}: polygon {}: expected vertices from {} to {}, found {}", path.string(),
                               polygon + 1, found.first, vertices - 1 + found.first, v + found.first)};
    corners.push_back(found.vertices[std::size_t(v)]);
  }
  const std::vector<Int3> cut = triangulate(corners);
  if (count >= 3 && cut.empty())
    return Error{fmt::format("{}: polygon {}: expected at most {} corners where it is not convex, found {}",
                             path.string(), polygon + 1, kMostConcaveCorners, count)};
  const auto vertex = [&](int corner) { return int(found.corners[begin + std::size_t(corner)]); };
  for (const auto [a, b, c] : cut) triangles.push_back({vertex(a), vertex(b), vertex(c)});
  return Done{};
}

/// Keeps the vertices that triangles use, in their order.
void drop_unused(TriMesh& mesh) {
  std::vector<int> number(mesh.vertices.size(), -1);
  for (const auto [a, b, c] : mesh.triangles)
    for (const int v : {a, b, c}) number[std::size_t(v)] = 0;
  std::vector<Vec3> kept;
  for (std::size_t v = 0; v < number.size(); v++)
    if (number[v] == 0) {
      number[v] = int(kept.size());
      kept.push_back(mesh.vertices[v]);
    }
  mesh.vertices = std::move(kept);
  for (Int3& t : mesh.triangles)
    t = {number[std::size_t(t.x)], number[std::size_t(t.y)], number[std::size_t(t.z)]};
}

}  // namespace

Result<ReadSurface> finish_surface(const fs::path& path, const FoundSurface& found, double scale) {
  if (Status done = check_positions(path, found, scale); !done) return done.error();
  std::vector<Int3> triangles;
  for (std::size_t p = 0; p < found.ends.size(); p++)
    if (Status done = triangulate_polygon(path, found, p, triangles); !done) return done.error();
  ReadSurface read{.format = found.format, .notes = found.notes};
  for (const Vec3d x : found.vertices) read.mesh.vertices.push_back(Vec3(x * scale) + Vec3{});  // -0 is 0
  read.mesh.triangles = triangles;
  read.mesh = welded(read.mesh);
  if (read.mesh.triangles.empty())
    return Error{
        fmt::format("{}: expected triangles, found none in this {} file", path.string(), found.format)};
  if (const std::size_t flat = triangles.size() - read.mesh.triangles.size())
    read.notes.push_back(fmt::format("dropped: {} with coincident corners", counted(flat, "triangle")));
  drop_unused(read.mesh);
  return read;
}

}  // namespace turgor::io
