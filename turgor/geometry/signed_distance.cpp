#include "turgor/geometry/signed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/distance_transform.hpp"
#include "turgor/geometry/winding_number.hpp"

namespace turgor {

namespace {

/// Sub-grid around all set samples, with a margin that may extend beyond the grid.
Grid cropped_grid(const Grid& grid, const std::vector<std::uint8_t>& inside, double margin, Int3& first) {
  Int3 low = grid.size, high{-1, -1, -1};
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++)
        if (inside[sample_index(grid, i, j, k)]) low = min(low, {i, j, k}), high = max(high, {i, j, k});
  TURGOR_ASSERT(high.x >= 0, "there is at least one voxel inside");
  Grid crop = grid;
  for (int axis = 0; axis < 3; axis++) {
    const int pad = int(std::ceil(margin / grid.spacing[axis])) + 1;
    first[axis] = low[axis] - pad;
    crop.size[axis] = high[axis] - low[axis] + 1 + 2 * pad;
  }
  crop.origin = point_at(grid, {double(first.x), double(first.y), double(first.z)});
  return crop;
}

std::vector<std::uint8_t> cropped(const Grid& grid, const std::vector<std::uint8_t>& inside, const Grid& crop,
                                  Int3 first) {
  std::vector<std::uint8_t> result(sample_count(crop));
  for (int k = 0; k < crop.size.z; k++)
    for (int j = 0; j < crop.size.y; j++)
      for (int i = 0; i < crop.size.x; i++)
        if (const Int3 p = first + Int3{i, j, k}; contains(grid, p))
          result[sample_index(crop, i, j, k)] = inside[sample_index(grid, p.x, p.y, p.z)];
  return result;
}

double finest(Vec3d spacing) { return std::min({spacing.x, spacing.y, spacing.z}); }

/// Distance from voxel centers to the faces between inside and outside, which are half a voxel before the
/// nearest center of the other side.
std::vector<float> mask_distance(const Exec& exec, const Grid& grid, std::vector<std::uint8_t> inside) {
  const float half = float(finest(grid.spacing) / 2);
  std::vector<float> distance = distance_transform(exec, grid, inside);
  for (std::uint8_t& voxel : inside) voxel = !voxel;
  const std::vector<float> depth = distance_transform(exec, grid, inside);
  for (std::size_t i = 0; i < distance.size(); i++)
    distance[i] = inside[i] ? distance[i] - half : half - depth[i];
  return distance;
}

/// Mean of the eight samples at the corners of every grid cell.
std::vector<float> cell_means(const Grid& grid, const std::vector<float>& samples) {
  std::vector<float> means;
  means.reserve(samples.size());
  for (int k = 0; k + 1 < grid.size.z; k++)
    for (int j = 0; j + 1 < grid.size.y; j++)
      for (int i = 0; i + 1 < grid.size.x; i++) {
        float sum = 0;
        for (int c = 0; c < 8; c++)
          sum += samples[sample_index(grid, i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))];
        means.push_back(sum / 8);
      }
  return means;
}

/// Level of the interpolated samples that encloses `count` voxels. Samples near the level count fractionally.
/// Samples and cell centers have Simpson weights, because interpolation raises the cell centers where the
/// surface is convex.
double level_of_count(const Grid& grid, const std::vector<float>& distance, double count) {
  const std::vector<float> means = cell_means(grid, distance);
  const double width = std::cbrt(sample_volume(grid));
  double low = -4 * width, high = 4 * width;
  const auto below = [&](const std::vector<float>& values, double level) {
    double sum = 0;
    for (const float d : values) sum += std::clamp(0.5 + (level - double(d)) / width, 0.0, 1.0);
    return sum;
  };
  for (int pass = 0; pass < 24; pass++) {
    const double level = (low + high) / 2;
    (below(distance, level) / 3 + below(means, level) * 2 / 3 < count ? low : high) = level;
  }
  return (low + high) / 2;
}

/// Samples with their map from positions to indices.
struct SampledField {
  Grid grid;
  Mat3d to_index;  // from meters after the origin
  std::vector<float> samples;

  double at(Vec3d p) const {
    Vec3d q = to_index * (p - grid.origin), kept;
    int cell[3];
    double f[3];
    for (int axis = 0; axis < 3; axis++) {
      kept[axis] = std::clamp(q[axis], 0.0, double(grid.size[axis] - 1));
      cell[axis] = std::min(int(kept[axis]), grid.size[axis] - 2);
      f[axis] = kept[axis] - cell[axis];
    }
    double sum = 0;
    for (int corner = 0; corner < 8; corner++) {
      const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      const double weight = (x ? f[0] : 1 - f[0]) * (y ? f[1] : 1 - f[1]) * (z ? f[2] : 1 - f[2]);
      sum += weight * double(samples[sample_index(grid, cell[0] + x, cell[1] + y, cell[2] + z)]);
    }
    return sum + norm(hadamard(q - kept, grid.spacing));
  }
};

Mat3d index_map(const Grid& grid) {
  const Vec3d s = grid.spacing;
  const Mat3d to_meters{{grid.axes.column[0] * s.x, grid.axes.column[1] * s.y, grid.axes.column[2] * s.z}};
  return inverse(to_meters);
}

SignedDistance read_in_box(SampledField field) {
  const Grid& grid = field.grid;
  Vec3d corners[8];
  for (int c = 0; c < 8; c++)
    corners[c] = point_at(grid, {c & 1 ? grid.size.x - 1.0 : 0.0, c & 2 ? grid.size.y - 1.0 : 0.0,
                                 c & 4 ? grid.size.z - 1.0 : 0.0});
  const Box box = box_around(corners);
  const auto shared = std::make_shared<const SampledField>(std::move(field));
  return {[shared](Vec3d p) { return shared->at(p); }, box.low, box.high};
}

}  // namespace

SignedDistance distance_to_surface(const TriMesh& surface) {
  struct Shape {
    TriangleTree tree;
    WindingNodes winding;

    double at(Vec3d p) const {
      const double distance = nearest_point(tree, p).distance;
      return std::abs(winding_number(tree, winding, p)) > 0.5 ? -distance : distance;
    }
  };
  std::vector<Vec3d> vertices;
  for (const Vec3 x : surface.vertices) vertices.push_back(Vec3d(x));
  auto shape = std::make_shared<Shape>();
  shape->tree = build_triangle_tree(std::move(vertices), surface.triangles);
  shape->winding = winding_nodes(shape->tree);
  TURGOR_ASSERT(!shape->tree.boxes.nodes.empty(), "a surface has triangles");
  const Box box = shape->tree.boxes.nodes[0].box;
  return {[shape](Vec3d p) { return shape->at(p); }, box.low, box.high};
}

SignedDistance distance_to_voxels(const Exec& exec, const Grid& grid, const std::vector<std::uint8_t>& inside,
                                  double smoothing) {
  Int3 first;
  const Grid crop = cropped_grid(grid, inside, 3 * smoothing, first);
  const std::vector<std::uint8_t> mask = cropped(grid, inside, crop, first);
  std::vector<float> distance = mask_distance(exec, crop, mask);
  smooth_gaussian(exec, crop, smoothing, distance);
  const double level = level_of_count(crop, distance, double(std::count(mask.begin(), mask.end(), 1)));
  for (float& d : distance) d -= float(level);
  return read_in_box({crop, index_map(crop), std::move(distance)});
}

}  // namespace turgor
