// Resampling of a tilted gantry's slices to a straight grid. Each slice is shifted in its own plane against
// the one before. Samples are moved back by interpolation within each slice, never between slices.
#include <algorithm>
#include <cmath>

#include "turgor/geometry/hounsfield.hpp"
#include "turgor/io/dicom/dicom.hpp"

namespace turgor::io {

namespace {

/// Shift along one axis of a slice, in samples.
struct Slant {
  double shift = 0;  // of a slice from the one before
  int low = 0;       // first index of the straight grid, relative to the first slice
  int size = 0;      // of the straight grid
};
Slant slant_of(double shift, int size, int slices) {
  constexpr double kWhole = 1e-3;  // precision of positions in files, in samples
  const double whole = shift * (slices - 1);
  const int low = int(std::floor(std::min(0.0, whole) + kWhole)),
            high = int(std::ceil(std::max(0.0, whole) - kWhole));
  return {shift, low, size + high - low};
}

/// Bilinear interpolation; air more than half a sample outside.
std::int16_t sample_at(const CtVolume& ct, double i, double j, int k) {
  const Int3 size = ct.grid.size;
  if (i < -0.5 || j < -0.5 || i > size.x - 0.5 || j > size.y - 0.5) return kAirHu;
  i = std::clamp(i, 0.0, size.x - 1.0), j = std::clamp(j, 0.0, size.y - 1.0);
  const int i0 = std::min(int(i), std::max(0, size.x - 2)), j0 = std::min(int(j), std::max(0, size.y - 2));
  const int i1 = std::min(i0 + 1, size.x - 1), j1 = std::min(j0 + 1, size.y - 1);
  const double a = i - i0, b = j - j0;
  const double near = ct.at(i0, j0, k) * (1 - a) + ct.at(i1, j0, k) * a;
  const double far = ct.at(i0, j1, k) * (1 - a) + ct.at(i1, j1, k) * a;
  return std::int16_t(std::lround(near * (1 - b) + far * b));
}

}  // namespace

Grid straight_grid(const Grid& grid, Vec3d shift) {
  const Slant i = slant_of(dot(shift, grid.axes.column[0]) / grid.spacing.x, grid.size.x, grid.size.z);
  const Slant j = slant_of(dot(shift, grid.axes.column[1]) / grid.spacing.y, grid.size.y, grid.size.z);
  Grid straight = grid;
  straight.size = {i.size, j.size, grid.size.z};
  straight.origin = point_at(grid, {double(i.low), double(j.low), 0});
  return straight;
}

CtVolume straightened(const Exec& exec, const CtVolume& ct, Vec3d shift) {
  CtVolume straight{straight_grid(ct.grid, shift), {}};
  straight.samples.resize(sample_count(straight.grid));
  const Vec3d low = index_at(ct.grid, straight.grid.origin);
  const double di = dot(shift, ct.grid.axes.column[0]) / ct.grid.spacing.x,
               dj = dot(shift, ct.grid.axes.column[1]) / ct.grid.spacing.y;
  parallel_for(exec, std::size_t(ct.grid.size.z), [&](std::size_t slice) {
    const int k = int(slice);
    for (int j = 0; j < straight.grid.size.y; j++)
      for (int i = 0; i < straight.grid.size.x; i++)
        straight.at(i, j, k) =
            sample_at(ct, i + std::round(low.x) - di * k, j + std::round(low.y) - dj * k, k);
  });
  return straight;
}

}  // namespace turgor::io
