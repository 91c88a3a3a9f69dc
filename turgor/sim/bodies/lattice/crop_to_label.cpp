#include "turgor/sim/bodies/lattice/crop_to_label.hpp"

#include <cmath>
#include <cstddef>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/labeled_component.hpp"

namespace turgor {

namespace {

/// Voxels of a CT inside a component of the labels. Indices map linearly between the two grids.
struct KeptVoxels {
  const LabelVolume& labels;
  const LabeledComponent& component;
  Vec3d first;
  Mat3d to_labels;

  KeptVoxels(const LabelVolume& l, const LabeledComponent& p, const Grid& ct)
      : labels(l), component(p), first(index_at(l.grid, point_at(ct, {}))) {
    for (int axis = 0; axis < 3; axis++) {
      Vec3d unit;
      unit[axis] = 1;
      to_labels.column[axis] = index_at(l.grid, point_at(ct, unit)) - first;
    }
  }
  bool operator()(Int3 voxel) const {
    const Vec3d at = first + to_labels * Vec3d(voxel);
    const Int3 p{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
    return contains(labels.grid, p) && component.inside[sample_index(labels.grid, p.x, p.y, p.z)] != 0;
  }
};

/// Voxels from low to below high; initially empty.
struct VoxelBox {
  Int3 low{1 << 30, 1 << 30, 1 << 30}, high{};

  void add(const VoxelBox& b) { low = min(low, b.low), high = max(high, b.high); }
};

CtVolume cut_out(const CtVolume& ct, const VoxelBox& box) {
  TURGOR_CHECK(box.low.x < box.high.x && box.low.y < box.high.y && box.low.z < box.high.z,
               "a cropped CT has voxels");
  // grid of the box
  CtVolume cropped;
  cropped.grid = ct.grid;
  cropped.grid.size = box.high - box.low;
  cropped.grid.origin = point_at(ct.grid, Vec3d(box.low));
  // copy rows of samples
  cropped.samples.reserve(sample_count(cropped.grid));
  for (int k = box.low.z; k < box.high.z; k++)
    for (int j = box.low.y; j < box.high.y; j++) {
      const auto row = ct.samples.begin() + std::ptrdiff_t(sample_index(ct.grid, 0, j, k));
      cropped.samples.insert(cropped.samples.end(), row + box.low.x, row + box.high.x);
    }
  return cropped;
}

}  // namespace

Status crop_to_label(const Exec& exec, const LabelVolume& labels, int label, Int3 margin, CtVolume& ct,
                     std::vector<std::string>& notes) {
  Result<LabeledComponent> component = largest_labeled_component(labels, std::span(&label, 1));
  if (!component) return component.error();
  fill_cavities(labels, {}, *component);
  notes.insert(notes.end(), component->notes.begin(), component->notes.end());
  const KeptVoxels is_kept(labels, *component, ct.grid);
  std::vector<VoxelBox> layers(std::size_t(ct.grid.size.z));
  parallel_for(exec, layers.size(), [&](std::size_t k) {
    for (int j = 0; j < ct.grid.size.y; j++)
      for (int i = 0; i < ct.grid.size.x; i++) {
        const Int3 voxel{i, j, int(k)};
        if (is_kept(voxel))
          layers[k].add({voxel, voxel + Int3{1, 1, 1}});
        else
          ct.at(i, j, int(k)) = kAirHu;
      }
  });
  VoxelBox box;
  for (const VoxelBox& layer : layers) box.add(layer);
  if (box.high.x == 0)
    return Error{"label " + std::to_string(label) + " lies outside the CT: expected a segmentation of it"};
  box.low = max(box.low - margin, Int3{}), box.high = min(box.high + margin, ct.grid.size);
  ct = cut_out(ct, box);
  return Done{};
}

}  // namespace turgor
