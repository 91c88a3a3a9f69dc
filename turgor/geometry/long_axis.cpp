#include "turgor/geometry/long_axis.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {

namespace {

/// Symmetric matrix of second moments.
struct SecondMoments {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;  // [m²]

  void add(Vec3d d) {
    xx += d.x * d.x, yy += d.y * d.y, zz += d.z * d.z;
    xy += d.x * d.y, xz += d.x * d.z, yz += d.y * d.z;
  }
  Vec3d times(Vec3d v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

/// Eigenvector of the largest eigenvalue, by power iteration from the longest column.
Vec3d largest_eigenvector(const SecondMoments& m) {
  constexpr int kIterations = 200;
  Vec3d v;
  for (const Vec3d e : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    if (const Vec3d column = m.times(e); norm(column) > norm(v)) v = column;
  if (norm(v) == 0) return {1, 0, 0};  // a single voxel
  v = normalized(v);
  for (int n = 0; n < kIterations; n++) v = normalized(m.times(v));
  const Vec3d size{std::abs(v.x), std::abs(v.y), std::abs(v.z)};
  const double most = size.x >= std::max(size.y, size.z) ? v.x : size.y >= size.z ? v.y : v.z;
  return most < 0 ? v * -1.0 : v;
}

template <class Visit>
void for_each_voxel_of(const LabelVolume& labels, int label, const Visit& visit) {
  for (int k = 0; k < labels.grid.size.z; k++)
    for (int j = 0; j < labels.grid.size.y; j++)
      for (int i = 0; i < labels.grid.size.x; i++)
        if (labels.at(i, j, k) == label) visit(point_at(labels.grid, Vec3d(Int3{i, j, k})));
}

}  // namespace

Vec3d long_axis(const LabelVolume& labels, int label) {
  // center
  Vec3d sum;
  double count = 0;
  for_each_voxel_of(labels, label, [&](Vec3d x) { sum += x, count++; });
  if (count == 0) return {};
  // moments about it
  SecondMoments moments;
  for_each_voxel_of(labels, label, [&](Vec3d x) { moments.add(x - sum / count); });
  return largest_eigenvector(moments);
}

}  // namespace turgor
