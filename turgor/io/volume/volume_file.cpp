#include "turgor/io/volume/volume_file.hpp"

#include <cmath>
#include <new>

#include <fmt/format.h>

#include "turgor/io/files/valid_position.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

Status check_grid(const fs::path& path, const Grid& grid) {
  for (int axis = 0; axis < 3; axis++) {
    const double spacing = grid.spacing[axis], origin = grid.origin[axis];
    if (!(spacing > 0) || !std::isfinite(spacing))
      return Error{fmt::format("{}: spacing along axis {} is {} mm; expected a positive number",
                               path.string(), axis, spacing * 1e3)};
    if (!std::isfinite(origin)) return Error{fmt::format("{}: the origin is not finite", path.string())};
    const Vec3d a = grid.axes.column[axis], b = grid.axes.column[(axis + 1) % 3];
    const double cosine = dot(a, b);
    if (!(std::abs(cosine) < 1e-3) || !(std::abs(norm(a) - 1) < 1e-3))
      return Error{fmt::format(
          "{}: axes {} and {} meet at {:.2f} degrees; expected orthogonal axes (resample the volume to an "
          "orthogonal grid first)",
          path.string(), axis, (axis + 1) % 3, std::acos(cosine) * 180 / M_PI)};
  }
  for (int c = 0; c < 8; c++) {
    const Vec3d p = point_at(grid, {c & 1 ? grid.size.x - 1.0 : 0.0, c & 2 ? grid.size.y - 1.0 : 0.0,
                                    c & 4 ? grid.size.z - 1.0 : 0.0});
    if (!is_valid_position(p))
      return Error{
          fmt::format("{}: expected samples within 1e+09 m of the origin of the patient, found one at "
                      "({:g}, {:g}, {:g}) m",
                      path.string(), p.x, p.y, p.z)};
  }
  return Done{};
}

Result<RawVolume> read_volume_file(const fs::path& path) {
  const Result<VolumeHeader> header = read_volume_header(path);
  if (!header) return header.error();
  if (Status grid = check_grid(path, header->grid); !grid) return grid.error();
  try {
    return read_volume_samples(path, *header);
  } catch (const std::bad_alloc&) {
    return Error{fmt::format("{}: cannot be read: not enough memory", path.string())};
  }
}

}  // namespace turgor::io
