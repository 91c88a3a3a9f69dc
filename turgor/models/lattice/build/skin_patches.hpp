// Patches of skin in partial cells, from the surface of the body in them.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// Langer's lines at a point, from the nearest voxel of their field; all in the patient frame.
Vec3d lines_at(const VectorVolume& lines, Vec3d point);

/// Patches of the cells that contain the surface and bear, in the order of slots. `lines`: Langer's lines in
/// the patient frame; null uses SkinParams::direction.
std::vector<SkinPatch> make_patches(std::span<const CellSurface> surfaces, const VectorVolume* lines,
                                    const Model& model);

}  // namespace turgor::lattice
