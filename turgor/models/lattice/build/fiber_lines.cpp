#include "turgor/models/lattice/build/fiber_lines.hpp"

#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// Sample nearest to a position in the patient frame; zero outside of the image or if it is not finite.
Vec3d nearest_line(const VectorVolume& field, Vec3d position) {
  const Vec3d at = index_at(field.grid, position);
  for (int axis = 0; axis < 3; axis++)
    if (!(at[axis] > -0.5 && at[axis] < field.grid.size[axis] - 0.5)) return {};
  const Vec3d line(field.at(int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))));
  return is_finite(line) ? line : Vec3d{};
}

}  // namespace

std::vector<Vec3> fiber_lines(const VectorVolume& field, const Model& model) {
  const Anatomy& anatomy = model.anatomy;
  const Mat3d to_lattice = inverse(anatomy.grid.axes);
  const Int3 size = anatomy.grid.size;
  std::vector<Vec3> lines(anatomy.cell_young.size());
  bool has_any = false;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const auto slot = std::size_t(node_slot(anatomy.lattice, {i, j, k}));
        if (!(anatomy.cell_young[slot] > 0)) continue;
        const Vec3d center = Vec3d(Int3{i, j, k}) + Vec3d{0.5, 0.5, 0.5};
        const Vec3d line = to_lattice * nearest_line(field, point_at(anatomy.grid, center));
        if (norm(line) == 0) continue;
        lines[slot] = Vec3(normalized(line));
        has_any = true;
      }
  if (!has_any) lines.clear();
  return lines;
}

void set_fiber_lines(std::span<const Vec3> lines, Model& model) {
  CellLaws& laws = model.anatomy.cell_laws;
  if (lines.empty() || laws.fiber.empty()) return;
  TURGOR_ASSERT(lines.size() == laws.fiber.size(), "directions of fibers are by slot");
  for (std::size_t slot = 0; slot < lines.size(); slot++)
    if (const Vec3 a = lines[slot]; a != Vec3{})
      laws.fiber_x[slot] = a.x, laws.fiber_y[slot] = a.y, laws.fiber_z[slot] = a.z;
}

}  // namespace turgor::lattice
