// What a CT shows beside the body: surroundings, which stay where they were, and the fringe, the air that a
// scanner blurs the skin into, which goes with the skin.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/lattice/resample/partial_volume_voxel.hpp"

namespace turgor::lattice {

/// Where the CT shows body.
class RestBody {
 public:
  RestBody(const Exec& exec, const Model& model, Vec3d first_node, Vec3d cell_size);

  bool holds(Vec3d at) const { return view().holds(at); }
  bool is_near_air(Int3 cell) const { return view().is_near_air(cell); }
  /// No body in the cells of a box.
  bool is_air(Vec3d low, Vec3d high) const;
  RestBodyView view() const { return {lattice_, first_node_, per_cell_, marks_.data()}; }
  const std::vector<std::uint8_t>& marks() const { return marks_; }

 private:
  const Lattice& lattice_;
  Vec3d first_node_, per_cell_;
  std::vector<std::uint8_t> marks_;  // RestMark by slot
};

/// A voxel of the output that tissue near the CT's air covers, and how far from there in the CT it lay
/// [voxels of the CT].
struct RimVoxel {
  Int3 voxel;
  Vec3 shift;
};
/// Leaves those with a voxel beside them that no tissue covers, row by row.
void keep_rim(const Grid& out, std::span<const std::uint8_t> covered, std::vector<RimVoxel>& rim);

/// An output whose tissue is drawn.
struct PartialVolumeInputs {
  const Model& model;
  const CtVolume& ct;
  const RestBody& rest;
  const Surroundings& beside;
  std::span<const std::uint8_t> covered;       // by voxel of the output: 1 = tissue
  std::span<const std::vector<RimVoxel>> rim;  // by slab of kVoxelLayers, as keep_rim leaves it
};

/// Fills the voxels of a slab that no tissue covers. Air within three voxels of the skin goes with the
/// nearest skin; what that air and the body have left is air; all else is as it was.
void fill_beside_body(const PartialVolumeInputs& inputs, int slab, CtVolume& out);

}  // namespace turgor::lattice
