// Voxels outside the deformed body: surroundings, which do not move, and partial volume, which moves with
// the skin. Partial volume is the air that a scanner blurs the skin into.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/lattice/resample/partial_volume_voxel.hpp"

namespace turgor::lattice {

/// Offsets of the 26 neighbors of a voxel: faces first, then edges, then corners.
std::array<Int3, 26> neighbors_by_distance();

/// Body as shown in the CT at rest.
class RestBody {
 public:
  RestBody(const Exec& exec, const Model& model, Vec3d first_node, Vec3d cell_size);

  bool holds(Vec3d at) const { return view().holds(at); }
  bool is_near_air(Int3 cell) const { return view().is_near_air(cell); }
  /// True if the cells of a box hold no body.
  bool is_air(Vec3d low, Vec3d high) const;
  RestBodyView view() const { return {lattice_, first_node_, per_cell_, marks_.data()}; }
  const std::vector<std::uint8_t>& marks() const { return marks_; }

 private:
  const Lattice& lattice_;
  Vec3d first_node_, per_cell_;
  std::vector<std::uint8_t> marks_;  // RestMark by slot
};

/// Voxel of the output covered by tissue near the CT's air, and its displacement to the rest position [voxels
/// of the CT].
struct RimVoxel {
  Int3 voxel;
  Vec3 shift;
};
/// Keeps the rim voxels next to a voxel without tissue, sorted row by row.
void keep_rim(const Grid& out, std::span<const std::uint8_t> covered, std::vector<RimVoxel>& rim);

/// Output volume after its tissue was filled in, and the inputs for the rest.
struct PartialVolumeInputs {
  const Model& model;
  const CtVolume& ct;
  const RestBody& rest;
  std::span<const std::uint8_t> covered;       // by voxel of the output: 1 = tissue
  std::span<const std::vector<RimVoxel>> rim;  // by slab of kVoxelLayers, from keep_rim
};

/// Fills the voxels of a slab that no tissue covers. Partial volume within three voxels moves with the
/// nearest skin. Voxels that it or the body left become air. All others keep their value.
void fill_outside_body(const PartialVolumeInputs& inputs, int slab, CtVolume& out);

}  // namespace turgor::lattice
