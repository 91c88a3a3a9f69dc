#include "turgor/models/lattice/build/skin_patches.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::lattice {

namespace {

/// Unit vector along Langer's lines in the plane with this unit normal; any direction if they are normal to
/// it.
Vec3d line_in_plane(Vec3d line, Vec3d normal) {
  const Vec3d along = line - normal * dot(normal, line);
  if (norm(along) >= 1e-6 * norm(line) && norm(line) > 0) return normalized(along);
  return normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
}

}  // namespace

Vec3d lines_at(const VectorVolume& lines, Vec3d point) {
  const Vec3d index = index_at(lines.grid, point);
  Int3 p;
  for (int axis = 0; axis < 3; axis++)
    p[axis] = std::clamp(int(std::lround(index[axis])), 0, lines.grid.size[axis] - 1);
  return Vec3d(lines.at(p.x, p.y, p.z));
}

std::vector<SkinPatch> make_patches(std::span<const CellSurface> surfaces, const VectorVolume* lines,
                                    const Model& model) {
  const Anatomy& anatomy = model.anatomy;
  const Mat3d to_lattice = inverse(anatomy.grid.axes);
  const Vec3d h(anatomy.lattice.spacing);
  const auto in_half_cells = [&](Vec3 x) { return Vec3(Vec3d{2 * x.x / h.x, 2 * x.y / h.y, 2 * x.z / h.z}); };
  std::vector<SkinPatch> patches;
  for (const CellSurface& surface : surfaces) {
    const int slot = node_slot(anatomy.lattice, surface.cell);
    if (!(anatomy.cell_young[std::size_t(slot)] > 0)) continue;
    // axes in the plane
    const Vec3d at = Vec3d(rest_position(anatomy.lattice, surface.cell) + surface.center);
    const Vec3d line =
        to_lattice * (lines != nullptr ? lines_at(*lines, anatomy.grid.origin + anatomy.grid.axes * at)
                                       : model.params.skin.direction);
    const double area = norm(Vec3d(surface.area));
    const Vec3d normal = Vec3d(surface.area) / area, along = line_in_plane(line, normal);
    patches.push_back({.cell = slot,
                       .point = in_half_cells(surface.center) - Vec3{1, 1, 1},
                       .reach1 = in_half_cells(surface.reach1),
                       .reach2 = in_half_cells(surface.reach2),
                       .along = Vec3(along),
                       .across = Vec3(cross(normal, along)),
                       .area = Real(area)});
  }
  std::sort(patches.begin(), patches.end(),
            [](const SkinPatch& a, const SkinPatch& b) { return a.cell < b.cell; });
  return patches;
}

}  // namespace turgor::lattice
