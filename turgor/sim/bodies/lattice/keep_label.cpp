#include "turgor/sim/bodies/lattice/keep_label.hpp"

#include <cmath>
#include <cstddef>

#include "turgor/geometry/labeled_component.hpp"

namespace turgor {

namespace {

/// Which voxels of a CT lie in a part of the labels. Places go linearly from one grid to the other.
struct KeptVoxels {
  const LabelVolume& labels;
  const LabeledPart& part;
  Vec3d first;
  Mat3d to_labels;

  KeptVoxels(const LabelVolume& l, const LabeledPart& p, const Grid& ct)
      : labels(l), part(p), first(index_at(l.grid, point_at(ct, {}))) {
    for (int axis = 0; axis < 3; axis++) {
      Vec3d unit;
      unit[axis] = 1;
      to_labels.column[axis] = index_at(l.grid, point_at(ct, unit)) - first;
    }
  }
  bool operator()(Int3 voxel) const {
    const Vec3d at = first + to_labels * Vec3d(voxel);
    const Int3 p{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
    return contains(labels.grid, p) && part.inside[sample_index(labels.grid, p.x, p.y, p.z)] != 0;
  }
};

/// Voxels from low to below high; empty at first.
struct VoxelBox {
  Int3 low{1 << 30, 1 << 30, 1 << 30}, high{};

  void add(const VoxelBox& b) { low = min(low, b.low), high = max(high, b.high); }
};

CtVolume cut_out(const CtVolume& ct, const VoxelBox& box) {
  CtVolume part;
  part.grid = ct.grid;
  part.grid.size = box.high - box.low;
  part.grid.origin = point_at(ct.grid, Vec3d(box.low));
  part.samples.reserve(sample_count(part.grid));
  for (int k = box.low.z; k < box.high.z; k++)
    for (int j = box.low.y; j < box.high.y; j++) {
      const auto row = ct.samples.begin() + std::ptrdiff_t(sample_index(ct.grid, 0, j, k));
      part.samples.insert(part.samples.end(), row + box.low.x, row + box.high.x);
    }
  return part;
}

}  // namespace

Status keep_label(const Exec& exec, const LabelVolume& labels, int label, Int3 margin, CtVolume& ct,
                  std::vector<std::string>& notes) {
  const Result<LabeledPart> part = largest_labeled_part(labels, std::span(&label, 1));
  if (!part) return part.error();
  notes.insert(notes.end(), part->notes.begin(), part->notes.end());
  const KeptVoxels is_kept(labels, *part, ct.grid);
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
