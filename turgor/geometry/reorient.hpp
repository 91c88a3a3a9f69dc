// Reorders and flips the axes of a volume, for example to match a segmentation stored left to right with a CT
// stored right to left. Values and positions of samples do not change.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Axis a of the new grid runs along axis source[a] of the old one, reversed if flip[a].
struct AxisOrder {
  std::array<int, 3> source{0, 1, 2};
  std::array<bool, 3> flip{};

  bool is_identity() const { return source == std::array{0, 1, 2} && flip == std::array<bool, 3>{}; }
};

/// Order that aligns axes `from` with axes `to`, if each is parallel to one of the other.
inline std::optional<AxisOrder> axis_order(const Mat3d& from, const Mat3d& to) {
  AxisOrder order;
  std::array<bool, 3> used{};
  for (int a = 0; a < 3; a++) {
    int best = -1;
    for (int b = 0; b < 3; b++)
      if (std::abs(dot(to.column[a], from.column[b])) > 0.99) best = b;
    if (best < 0 || used[std::size_t(best)]) return std::nullopt;
    used[std::size_t(best)] = true;
    order.source[std::size_t(a)] = best;
    order.flip[std::size_t(a)] = dot(to.column[a], from.column[best]) < 0;
  }
  return order;
}

inline Grid reordered(const Grid& grid, const AxisOrder& order) {
  Grid out = grid;
  Vec3d first;  // index in the old grid of the new sample (0, 0, 0)
  for (int a = 0; a < 3; a++) {
    const int b = order.source[std::size_t(a)];
    const bool flip = order.flip[std::size_t(a)];
    out.size[a] = grid.size[b];
    out.spacing[a] = grid.spacing[b];
    out.axes.column[a] = flip ? -grid.axes.column[b] : grid.axes.column[b];
    if (flip) first[b] = grid.size[b] - 1;
  }
  out.origin = point_at(grid, first);
  return out;
}

template <class T>
Volume<T> reordered(const Volume<T>& volume, const AxisOrder& order) {
  Volume<T> out{reordered(volume.grid, order), {}};
  out.samples.resize(volume.samples.size());
  const std::ptrdiff_t strides[3] = {1, volume.grid.size.x,
                                     std::ptrdiff_t(volume.grid.size.x) * volume.grid.size.y};
  std::ptrdiff_t first = 0, step[3];
  for (int a = 0; a < 3; a++) {
    const std::ptrdiff_t stride = strides[order.source[std::size_t(a)]];
    step[a] = order.flip[std::size_t(a)] ? -stride : stride;
    if (order.flip[std::size_t(a)]) first += stride * (out.grid.size[a] - 1);
  }
  const T* source = volume.samples.data();
  T* target = out.samples.data();
  for (int k = 0; k < out.grid.size.z; k++)
    for (int j = 0; j < out.grid.size.y; j++)
      for (int i = 0; i < out.grid.size.x; i++)
        *target++ = source[first + i * step[0] + j * step[1] + k * step[2]];
  return out;
}

/// The volume reordered to the axes of `grid`; empty if its samples are not at those of `grid`.
template <class T>
std::optional<Volume<T>> on_grid(const Volume<T>& volume, const Grid& grid) {
  const std::optional<AxisOrder> order = axis_order(volume.grid.axes, grid.axes);
  if (!order || !same_grid(reordered(volume.grid, *order), grid)) return std::nullopt;
  Volume<T> out = reordered(volume, *order);
  out.grid = grid;
  return out;
}

/// First sample of `grid` under a box with the same axes: the nearest to its origin, perhaps outside.
inline Int3 first_covered(const Grid& box, const Grid& grid) {
  const Vec3d at = index_at(grid, box.origin);
  const auto whole = [](double index) { return int(std::lround(std::clamp(index, -1e9, 1e9))); };
  return {whole(at.x), whole(at.y), whole(at.z)};
}

/// The same for a volume that covers a sub-box of `grid`, sample on sample: 0 elsewhere.
template <class T>
std::optional<Volume<T>> part_on_grid(const Volume<T>& volume, const Grid& grid) {
  const std::optional<AxisOrder> order = axis_order(volume.grid.axes, grid.axes);
  if (!order) return std::nullopt;
  const Volume<T> reordered_volume = reordered(volume, *order);
  const Int3 first = first_covered(reordered_volume.grid, grid);
  Grid covered = grid;
  covered.size = reordered_volume.grid.size;
  covered.origin = point_at(grid, Vec3d(first));
  const Int3 last = first + reordered_volume.grid.size;
  for (int axis = 0; axis < 3; axis++)
    if (first[axis] < 0 || last[axis] > grid.size[axis]) return std::nullopt;
  if (!same_grid(reordered_volume.grid, covered)) return std::nullopt;
  Volume<T> out{grid, std::vector<T>(sample_count(grid))};
  for (int k = 0; k < covered.size.z; k++)
    for (int j = 0; j < covered.size.y; j++)
      std::copy_n(
          reordered_volume.samples.begin() + std::ptrdiff_t(sample_index(reordered_volume.grid, 0, j, k)),
          covered.size.x,
          out.samples.begin() + std::ptrdiff_t(sample_index(grid, first.x, first.y + j, first.z + k)));
  return out;
}

/// Mirrors the order of samples along i if the axes are left-handed.
template <class T>
Volume<T> right_handed(Volume<T> volume) {
  if (determinant(volume.grid.axes) > 0) return volume;
  return reordered(volume, AxisOrder{.flip = {true, false, false}});
}

}  // namespace turgor
