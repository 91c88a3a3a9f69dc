// What a CT shows beside the body: surroundings, which stay where they were, and the fringe, the air that a
// scanner blurs the skin into, which goes with the skin.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/lattice/beside_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// Where the CT shows body: the tetrahedra with a node of body. Places are indices of the CT's voxels.
class RestBody {
 public:
  RestBody(const Exec& exec, const Model& model, Vec3d first_node, Vec3d cell_size);

  bool holds(Vec3d at) const;
  /// No body in the cells of a box.
  bool is_air(Vec3d low, Vec3d high) const;
  /// A cell with a node that is no body and one that is, or one beside such a cell?
  bool is_near_air(Int3 cell) const { return near_air_[std::size_t(node_slot(model_.lattice, cell))]; }

 private:
  const Model& model_;
  Vec3d first_node_, per_cell_;
  enum class Cell : std::uint8_t { kAir, kRim, kBody };
  std::vector<Cell> cells_;             // by slot of the lower corner
  std::vector<std::uint8_t> near_air_;  // likewise
};

/// The way from voxels of an output to those of the CT, where nothing has moved.
struct PlaceInCt {
  Vec3d first;
  Mat3d step;

  PlaceInCt(const Grid& out, const Grid& ct);
  Vec3d operator()(Int3 voxel) const { return first + step * Vec3d(voxel); }
};

/// A voxel of the output that tissue near the CT's air covers, and how far from there in the CT it lay
/// [voxels of the CT].
struct RimVoxel {
  Int3 voxel;
  Vec3 shift;
};
/// `at`: where the tissue lay. In parts of 1/1024, so that what has not moved has no shift.
RimVoxel rim_voxel(const PlaceInCt& place, Int3 voxel, Vec3 at);
/// Leaves those with a voxel beside them that no tissue covers, row by row.
void keep_rim(const Grid& out, std::span<const std::uint8_t> covered, std::vector<RimVoxel>& rim);

/// An output whose tissue is drawn.
struct FringeInputs {
  const Model& model;
  const CtVolume& ct;
  const RestBody& rest;
  const BesideBody& beside;
  std::span<const std::uint8_t> covered;       // by voxel of the output: 1 = tissue
  std::span<const std::vector<RimVoxel>> rim;  // by slab of kVoxelLayers, as keep_rim leaves it
};

/// Fills the voxels of a slab that no tissue covers. Air within three voxels of the skin goes with the
/// nearest skin; what that air and the body have left is air; all else is as it was.
void fill_beside_body(const FringeInputs& inputs, int slab, CtVolume& out);

}  // namespace turgor::lattice
